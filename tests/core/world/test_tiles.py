from warehouse_core.world.tiles import (
    CELL_CODES,
    CODE_OF_BYTE,
    OTHER_EMPTY,
    OTHER_LOADED,
    PERSON,
    TILES,
    manhattan_distance,
    moved,
    runs_of,
)


def test_a_cell_is_moved_by_rows_and_columns() -> None:
    assert moved((3, 5), (-1, 2)) == (2, 7)


def test_the_manhattan_distance_ignores_directions() -> None:
    assert manhattan_distance((1, 7), (4, 5)) == manhattan_distance((4, 5), (1, 7)) == 5


def test_runs_are_given_by_their_first_column_and_their_end() -> None:
    assert runs_of("#", "##.#..###") == [(0, 2), (3, 4), (6, 9)]
    assert runs_of("#", "...") == []


def test_the_codes_are_the_same_in_both_tables() -> None:
    assert "".join(CELL_CODES) == ".#PDRrCOoH"
    assert list("".join(CELL_CODES).encode().translate(CODE_OF_BYTE)) == list(range(10))
    assert CODE_OF_BYTE[ord("?")] == 255


def test_others_and_people_have_larger_codes_than_every_tile() -> None:
    largest = max(CELL_CODES[tile] for tile in TILES)
    assert all(CELL_CODES[other] > largest for other in (OTHER_EMPTY, OTHER_LOADED, PERSON))
