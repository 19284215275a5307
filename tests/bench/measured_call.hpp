// The function within which callgrind counts.
#pragma once

#include <functional>

// In a file of its own, so that no compiler merges it with its caller.
extern "C" void contourd_measured_call(const std::function<void()>& call);
