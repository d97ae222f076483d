#pragma once

void crtpSupervisorInit(void);
