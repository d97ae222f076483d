"""A copy of what moves in a world, for eyes: looking at it touches nothing of a flight."""

import mujoco


class Likeness:
    """The state of a world as cameras and viewers want it.

    Attributes:
        data: The copy; only what is needed to draw it is up to date.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self.data = mujoco.MjData(model)

    def update(self, moving: mujoco.MjData) -> mujoco.MjData:
        """Take over poses, with kinematics of this very instant: those of *moving* are a step older. Returns `data`."""
        model, data = self._model, self.data
        data.time = moving.time
        data.qpos[:], data.mocap_pos[:], data.mocap_quat[:] = moving.qpos, moving.mocap_pos, moving.mocap_quat
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_camlight(model, data)
        if model.nflex:
            mujoco.mj_flex(model, data)
        if model.ntendon:
            mujoco.mj_tendon(model, data)
        return data
