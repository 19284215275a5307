// Tests with a fake ioctl(): its one descriptor is a line of the first or the second kernel interface. Real
// lines are tested in the virtual machine (tests/vm).
#include "hw/gpio/gpio_lines.hpp"

#include <linux/gpio.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>

#include "tests/catch.hpp"

namespace {

constexpr int kDescriptor = 1'000'000;

struct Kernel {
  unsigned long answers = 0;  // the request that the line supports
  bool refuses = false;
  std::vector<unsigned long> asked{};
  gpio_v2_line_values second{};
  gpiohandle_data first{};
};
Kernel kernel;

int answer(unsigned long request, void* argument) {
  kernel.asked.push_back(request);
  if (request != kernel.answers || kernel.refuses) {
    errno = EINVAL;
    return -1;
  }
  if (request == GPIO_V2_LINE_SET_VALUES_IOCTL) kernel.second = *static_cast<gpio_v2_line_values*>(argument);
  if (request == GPIOHANDLE_SET_LINE_VALUES_IOCTL) kernel.first = *static_cast<gpiohandle_data*>(argument);
  return 0;
}

}  // namespace

extern "C" int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  if (descriptor == kDescriptor) return answer(request, argument);
  return static_cast<int>(syscall(SYS_ioctl, descriptor, request, argument));
}

TEST_CASE("A line is made inactive through the kernel interface by which it was requested") {
  kernel = {.answers = GPIO_V2_LINE_SET_VALUES_IOCTL};
  kernel.second.bits = 1;
  CHECK(contourd::set_line_inactive(kDescriptor));
  CHECK(kernel.asked.size() == 1);
  CHECK(kernel.second.mask == 1);
  CHECK(kernel.second.bits == 0);

  kernel = {.answers = GPIOHANDLE_SET_LINE_VALUES_IOCTL};
  kernel.first.values[0] = 1;
  CHECK(contourd::set_line_inactive(kDescriptor));
  CHECK(kernel.first.values[0] == 0);
}

TEST_CASE("A line that the kernel refuses to set, and a descriptor that is no line, give false") {
  kernel = {.answers = GPIOHANDLE_SET_LINE_VALUES_IOCTL, .refuses = true};
  CHECK_FALSE(contourd::set_line_inactive(kDescriptor));
  CHECK(kernel.asked.size() == 2);
  CHECK_FALSE(contourd::set_line_inactive(-1));
  int pipe_ends[2];
  REQUIRE(pipe(pipe_ends) == 0);
  CHECK_FALSE(contourd::set_line_inactive(pipe_ends[1]));
  close(pipe_ends[0]);
  close(pipe_ends[1]);
}
