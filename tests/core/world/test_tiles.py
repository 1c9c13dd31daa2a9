from warehouse_core.world.tiles import CELL_CODES, CODE_OF_BYTE, runs_of


def test_runs_are_given_by_their_first_column_and_their_end() -> None:
    assert runs_of("#", "##.#..###") == [(0, 2), (3, 4), (6, 9)]
    assert runs_of("#", "...") == []


def test_the_codes_are_the_same_in_both_tables_and_largest_for_others_and_people() -> None:
    assert "".join(CELL_CODES) == ".#PDRrCOoH"
    assert list("".join(CELL_CODES).encode().translate(CODE_OF_BYTE)) == list(range(10))
    assert CODE_OF_BYTE[ord("?")] == 255
