"""Programs that fly one drone each, as the per-drone plugins of a simulator do: `MotorCtrl` and its family."""

from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_fpqr import MotorCtrlFPQR
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_frpy import MotorCtrlFRPY
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_vel import MotorCtrlVel
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_xyz import MotorCtrlXYZ

__all__ = ["MotorCtrl", "MotorCtrlFPQR", "MotorCtrlFRPY", "MotorCtrlVel", "MotorCtrlXYZ"]
