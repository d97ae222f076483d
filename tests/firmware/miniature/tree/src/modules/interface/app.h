// What a user's application brings.
#pragma once

void appMain();
void appInit();
