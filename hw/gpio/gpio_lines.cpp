#include "hw/gpio/gpio_lines.hpp"

#include <linux/gpio.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <system_error>
#include <vector>

namespace contourd {
namespace {

namespace fs = std::filesystem;

struct FoundLine {
  fs::path device;
  GpioLineReport report;
};

std::vector<fs::path> chip_devices(const fs::path& devices) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(devices, ignored)) {
    if (entry.path().filename().string().starts_with("gpiochip")) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::string why(int error) {
  return std::generic_category().message(error);
}

[[noreturn]] void refuse_chip(const fs::path& device, int error) {
  if (error == EACCES || error == EPERM) {
    throw HardwareError("no permission to open " + device.string() +
                        ": the user that contourd runs as must be in the group that owns it (gpio)");
  }
  if (error == ENOTTY || error == ENODEV || error == EINVAL) {
    throw HardwareError(device.string() + " is not a GPIO chip");
  }
  throw HardwareError("cannot open GPIO chip " + device.string() + ": " + why(error));
}

// "existing chips: gpiochip0 (pinctrl-bcm2711), gpiochip1 (raspberrypi-exp-gpio)"
std::string existing_chips(const fs::path& devices) {
  std::string names;
  for (const fs::path& device : chip_devices(devices)) {
    if (!names.empty()) names += ", ";
    names += device.filename().string();
    try {
      names += " (" + GpiodChip(device).label() + ")";
    } catch (const std::system_error& error) {
      names += " (" + why(error.code().value()) + ")";
    }
  }
  return names.empty() ? "there is no GPIO chip below " + devices.string() : "existing chips: " + names;
}

fs::path find_chip(const std::string& chip, const fs::path& devices) {
  const bool is_path = chip.find('/') != std::string::npos;
  const fs::path device = is_path ? fs::path(chip) : devices / chip;
  std::error_code ignored;
  if (!chip.empty() && fs::exists(device, ignored)) return device;
  int refused = 0;
  fs::path refused_device;
  for (const fs::path& candidate : is_path ? std::vector<fs::path>{} : chip_devices(devices)) {
    try {
      if (GpiodChip(candidate).label() == chip) return candidate;
    } catch (const std::system_error& error) {
      refused = error.code().value();
      refused_device = candidate;
    }
  }
  if (refused == EACCES || refused == EPERM)
    refuse_chip(refused_device, refused);  // this may be the wanted chip
  throw HardwareError("there is no GPIO chip \"" + chip + "\" by device name, path or label; " +
                      existing_chips(devices));
}

std::string chip_words(const GpiodChip& chip) {
  return chip.name() + " (" + chip.label() + ")";
}

std::optional<unsigned> whole_number(const std::string& text) {
  unsigned number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

unsigned find_offset(const GpiodChip& chip, const std::string& line) {
  const unsigned count = chip.line_count();
  if (const auto number = whole_number(line)) {
    if (*number < count) return *number;
    throw HardwareError("there is no line " + line + " on " + chip_words(chip) + "; its lines are 0 to " +
                        std::to_string(count - 1));
  }
  std::string names;
  for (unsigned offset = 0; offset < count; ++offset) {
    const std::string name = chip.line_info(offset).name;
    if (name == line && !name.empty()) return offset;
    if (!name.empty()) names += (names.empty() ? "" : ", ") + name;
  }
  throw HardwareError("there is no line named \"" + line + "\" on " + chip_words(chip) + "; " +
                      (names.empty()
                           ? "its lines have no names, only the numbers 0 to " + std::to_string(count - 1)
                           : "its named lines are " + names));
}

FoundLine find_line(const GpioLineConfig& config, const fs::path& devices) {
  const fs::path device = find_chip(config.chip, devices);
  try {
    const GpiodChip chip(device);
    const unsigned offset = find_offset(chip, config.line);
    const GpiodLineInfo info = chip.line_info(offset);
    return {device, {chip.name(), chip.label(), offset, info.name, info.consumer, info.output}};
  } catch (const std::system_error& error) {
    refuse_chip(device, error.code().value());
  }
}

std::string line_words(const GpioLineReport& line) {
  return "line " + std::to_string(line.offset) + (line.name.empty() ? "" : " (" + line.name + ")") + " of " +
         line.chip + " (" + line.label + ")";
}

std::string used_by(const std::optional<std::string>& consumer) {
  return consumer && !consumer->empty() ? "\"" + *consumer + "\"" : "a program that gives no name";
}

GpiodLine::Request request_of(const FoundLine& line, const GpioLineConfig& config, std::string_view use) {
  return {line.device, line.report.offset, config.active_low, "contourd " + std::string(use)};
}

// Finds the line and requests it by `take(request)`.
template <typename Take>
GpiodLine take_line(const GpioLineConfig& config, std::string_view use, const Take& take) {
  const FoundLine found = find_line(config, "/dev");
  try {
    return take(request_of(found, config, use));
  } catch (const std::system_error& error) {
    const std::string what = line_words(found.report) + ", the " + std::string(use) + " line,";
    if (error.code().value() == EBUSY) {
      // The line is looked up again, because its holder may have taken it after the first look-up.
      throw HardwareError(what + " is used by " + used_by(find_line(config, "/dev").report.consumer));
    }
    throw HardwareError(what + " cannot be taken: " + why(error.code().value()));
  }
}

}  // namespace

bool set_line_inactive(int descriptor) noexcept {
  gpio_v2_line_values second{};
  second.mask = 1;
  if (ioctl(descriptor, GPIO_V2_LINE_SET_VALUES_IOCTL, &second) == 0) return true;
  gpiohandle_data first{};
  return ioctl(descriptor, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &first) == 0;
}

GpioOutput::GpioOutput(const GpioLineConfig& config, std::string_view use, bool active)
    : line_(take_line(config, use, [active](const GpiodLine::Request& request) {
        return GpiodLine::output(request, active);
      })) {}

GpioInput::GpioInput(const GpioLineConfig& config, LineBias bias, std::string_view use)
    : line_(take_line(config, use, [bias](const GpiodLine::Request& request) {
        return GpiodLine::input(request, bias);
      })) {}

GpioLineReport report_line(const GpioLineConfig& config, const std::filesystem::path& devices) {
  return find_line(config, devices).report;
}

std::string describe(const GpioLineReport& report) {
  return line_words(report) + (report.output ? ", an output, " : ", an input, ") +
         (report.consumer ? "used by " + used_by(report.consumer) : "free");
}

}  // namespace contourd
