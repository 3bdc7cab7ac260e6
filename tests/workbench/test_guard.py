"""The way to the page, and names of files, without a page: no secret is shown, no name leads elsewhere."""

import pytest

from station.results.sessions import safe_name


def test_the_browser_is_sent_to_the_page_without_the_token_among_its_arguments(tmp_path):
    from station.workbench.server import _way_to

    address = _way_to("http://127.0.0.1:1/?session=a&token=secret", tmp_path)
    assert "secret" not in address
    assert 'url=http://127.0.0.1:1/?session=a&amp;token=secret"' in (tmp_path / "open.html").read_text()


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ("decay.csv", "decay.csv"),
        ("../../.ssh/authorized_keys", "ssh_authorized_keys"),
        ("C:\\Windows\\decay.MAT", "C_Windows_decay.MAT"),
        ("<b>x</b>.csv", "b_x_b_.csv"),
        ("..", "recording"),
        ("\x00.csv", "csv"),
        ("ä ö.csv", "ä_ö.csv"),
    ],
)
def test_a_file_name_leads_out_of_no_folder(given, kept):
    assert safe_name(given) == kept
