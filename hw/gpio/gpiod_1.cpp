#include <fcntl.h>
#include <gpiod.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "hw/gpio/gpiod.hpp"

namespace contourd {
namespace {

[[noreturn]] void fail() {
  throw std::system_error(errno, std::generic_category());
}

int line_flags(bool active_low, LineBias bias) {
  int flags = active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  if (bias == LineBias::PullUp) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
  if (bias == LineBias::PullDown) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  if (bias == LineBias::Off) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
  return flags;
}

TimePoint time_point(const timespec& time) {
  return TimePoint{std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec}};
}

// Returns this process' descriptors that hold output lines, sorted.
std::vector<int> line_handles() {
  std::vector<int> found;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", ignored)) {
    if (std::filesystem::read_symlink(entry.path(), ignored) != "anon_inode:gpio-linehandle") continue;
    const std::string name = entry.path().filename().string();
    int descriptor = -1;
    std::from_chars(name.data(), name.data() + name.size(), descriptor);
    found.push_back(descriptor);
  }
  std::sort(found.begin(), found.end());
  return found;
}

// Returns the descriptor of an output line that is not in `before`, or -1.
int new_line_handle(const std::vector<int>& before) {
  for (const int descriptor : line_handles()) {
    if (!std::binary_search(before.begin(), before.end(), descriptor)) return descriptor;
  }
  return -1;
}

}  // namespace

GpiodChip::GpiodChip(const std::filesystem::path& device) : chip_(gpiod_chip_open(device.c_str())) {
  if (chip_ == nullptr) fail();
  name_ = gpiod_chip_name(chip_);
  label_ = gpiod_chip_label(chip_);
  line_count_ = gpiod_chip_num_lines(chip_);
}

GpiodChip::~GpiodChip() {
  gpiod_chip_close(chip_);
}

GpiodLineInfo GpiodChip::line_info(unsigned offset) const {
  gpiod_line* line = gpiod_chip_get_line(chip_, offset);
  if (line == nullptr || gpiod_line_update(line) != 0) fail();
  const auto text = [](const char* words) { return std::string(words != nullptr ? words : ""); };
  GpiodLineInfo info;
  info.name = text(gpiod_line_name(line));
  if (gpiod_line_is_used(line)) info.consumer = text(gpiod_line_consumer(line));
  info.output = gpiod_line_direction(line) == GPIOD_LINE_DIRECTION_OUTPUT;
  return info;
}

// In this version of the library a line belongs to its chip's handle, so each line has a chip of its own.
struct GpiodLine::Handle {
  explicit Handle(const Request& request) : chip(request.device) {}
  ~Handle() {
    if (line != nullptr) gpiod_line_release(line);
  }
  GpiodChip chip;
  gpiod_line* line = nullptr;
  int descriptor = -1;  // an output's; this version of the library has no call for it
};

GpiodLine::GpiodLine(std::unique_ptr<Handle> handle) : handle_(std::move(handle)) {}
GpiodLine::GpiodLine(GpiodLine&&) noexcept = default;
GpiodLine::~GpiodLine() = default;

GpiodLine GpiodLine::output(const Request& request, bool active) {
  auto handle = std::make_unique<Handle>(request);
  gpiod_line* line = gpiod_chip_get_line(handle->chip.chip_, request.offset);
  const int flags = line_flags(request.active_low, LineBias::AsIs);
  const std::vector<int> before = line_handles();
  if (line == nullptr ||
      gpiod_line_request_output_flags(line, request.consumer.c_str(), flags, active ? 1 : 0) != 0) {
    fail();
  }
  handle->line = line;
  handle->descriptor = new_line_handle(before);
  return GpiodLine(std::move(handle));
}

GpiodLine GpiodLine::input(const Request& request, LineBias bias) {
  auto handle = std::make_unique<Handle>(request);
  gpiod_line* line = gpiod_chip_get_line(handle->chip.chip_, request.offset);
  const int flags = line_flags(request.active_low, bias);
  if (line == nullptr ||
      gpiod_line_request_both_edges_events_flags(line, request.consumer.c_str(), flags) != 0) {
    fail();
  }
  handle->line = line;
  const int fd = gpiod_line_event_get_fd(line);
  if (fd < 0 || fcntl(fd, F_SETFL, O_NONBLOCK) != 0) fail();
  return GpiodLine(std::move(handle));
}

bool GpiodLine::set(bool active) noexcept {
  return gpiod_line_set_value(handle_->line, active ? 1 : 0) == 0;
}

int GpiodLine::descriptor() const noexcept {
  return handle_->descriptor;
}

std::optional<bool> GpiodLine::get() noexcept {
  const int value = gpiod_line_get_value(handle_->line);
  return value < 0 ? std::nullopt : std::optional(value != 0);
}

int GpiodLine::event_descriptor() const noexcept {
  return gpiod_line_event_get_fd(handle_->line);
}

std::size_t GpiodLine::read_edges(std::span<LineEdge> edges) noexcept {
  std::array<gpiod_line_event, 16> events;  // the kernel keeps at most 16
  const std::size_t room = std::min(events.size(), edges.size());
  const int count =
      gpiod_line_event_read_fd_multiple(event_descriptor(), events.data(), static_cast<unsigned>(room));
  for (int i = 0; i < count; ++i) {
    const auto& event = events[static_cast<std::size_t>(i)];
    edges[static_cast<std::size_t>(i)] = {event.event_type == GPIOD_LINE_EVENT_RISING_EDGE,
                                          time_point(event.ts)};
  }
  return count < 0 ? 0 : static_cast<std::size_t>(count);
}

}  // namespace contourd
