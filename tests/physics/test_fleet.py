import pytest
from helpers.fleet_truth import bodies_move_as_the_grid


@pytest.mark.filterwarnings("ignore:.*chargers supply")
@pytest.mark.parametrize(("robots", "joint_actions"), [(2, 60), (7, 60), (25, 40), (100, 8)])
def test_a_nominal_fleet_of_bodies_equals_that_of_the_grid(robots: int, joint_actions: int) -> None:
    stops = bodies_move_as_the_grid(robots, joint_actions, seed=robots)
    assert stops.total() == robots * joint_actions
    assert min(stops["free"], stops["wall"], stops["robot"]) > 0
