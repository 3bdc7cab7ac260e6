"""The long proofs: each module measures one thing and writes its section of docs/benchmarks.md."""
