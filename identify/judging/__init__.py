"""The judge: which effects a record supports, by the evidence of fits with each of them."""
