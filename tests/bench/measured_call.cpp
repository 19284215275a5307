#include "tests/bench/measured_call.hpp"

void contourd_measured_call(const std::function<void()>& call) {
  call();
}
