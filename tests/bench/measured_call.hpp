// The function in which callgrind counts instructions.
#pragma once

#include <functional>

// Calls `call`. Defined in a separate file, so that no compiler merges it with its caller.
extern "C" void contourd_measured_call(const std::function<void()>& call);
