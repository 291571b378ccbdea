"""Several lidars on one vehicle."""

import numpy as np

import mapless

RIG = """
sensors:
  - {name: roof, model: VLP-16, position_m: [0, 0, 0], quaternion_xyzw: [0, 0, 0, 1]}
  - {name: bumper, model: VLP-16, position_m: [2.2, 0, -1.4], quaternion_xyzw: [0, 0, 0, 1]}
"""


def test_every_sensor_of_a_simulated_rig_has_a_result_along_one_motion(tmp_path):
    (tmp_path / "two.yaml").write_text(RIG)
    mapless.simulate("crossing", tmp_path / "rig", rig=tmp_path / "two.yaml", duration_s=1, seed=3, world="level")
    results = mapless.detect_rig(tmp_path / "rig", tmp_path / "out")
    assert sorted(results) == ["bumper", "roof"]
    assert [len(result) for result in results.values()] == [10, 10]
    between = np.linalg.inv(results["roof"].poses()) @ results["bumper"].poses()
    np.testing.assert_allclose(between[:, :3, 3], [[2.2, 0, -1.4]] * 10, atol=1e-5)
