#include <fcntl.h>
#include <gpiod.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "hw/gpio/gpiod.hpp"
#include "hw/owned.hpp"

namespace contourd {
namespace {

[[noreturn]] void fail() {
  throw std::system_error(errno, std::generic_category());
}

template <typename T>
T* made(T* object) {
  if (object == nullptr) fail();
  return object;
}

using Info = Owned<gpiod_line_info, gpiod_line_info_free>;
using Settings = Owned<gpiod_line_settings, gpiod_line_settings_free>;
using LineConfig = Owned<gpiod_line_config, gpiod_line_config_free>;
using RequestConfig = Owned<gpiod_request_config, gpiod_request_config_free>;
using LineRequest = Owned<gpiod_line_request, gpiod_line_request_release>;
using EventBuffer = Owned<gpiod_edge_event_buffer, gpiod_edge_event_buffer_free>;

constexpr std::size_t kEvents = 64;  // number of events that the kernel keeps and that one read returns

gpiod_line_bias line_bias(LineBias bias) {
  constexpr std::array kByLineBias{GPIOD_LINE_BIAS_AS_IS, GPIOD_LINE_BIAS_PULL_UP, GPIOD_LINE_BIAS_PULL_DOWN,
                                   GPIOD_LINE_BIAS_DISABLED};
  return kByLineBias[static_cast<std::size_t>(bias)];
}

gpiod_line_value line_value(bool active) {
  return active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
}

}  // namespace

GpiodChip::GpiodChip(const std::filesystem::path& device) : chip_(gpiod_chip_open(device.c_str())) {
  if (chip_ == nullptr) fail();
  const Owned<gpiod_chip_info, gpiod_chip_info_free> info(gpiod_chip_get_info(chip_));
  if (!info) {
    const int error = errno;
    gpiod_chip_close(chip_);
    throw std::system_error(error, std::generic_category());
  }
  name_ = gpiod_chip_info_get_name(info.get());
  label_ = gpiod_chip_info_get_label(info.get());
  line_count_ = static_cast<unsigned>(gpiod_chip_info_get_num_lines(info.get()));
}

GpiodChip::~GpiodChip() {
  gpiod_chip_close(chip_);
}

GpiodLineInfo GpiodChip::line_info(unsigned offset) const {
  const Info line(made(gpiod_chip_get_line_info(chip_, offset)));
  const auto text = [](const char* words) { return std::string(words != nullptr ? words : ""); };
  GpiodLineInfo info;
  info.name = text(gpiod_line_info_get_name(line.get()));
  if (gpiod_line_info_is_used(line.get())) info.consumer = text(gpiod_line_info_get_consumer(line.get()));
  info.output = gpiod_line_info_get_direction(line.get()) == GPIOD_LINE_DIRECTION_OUTPUT;
  return info;
}

struct GpiodLine::Handle {
  Handle(const Request& asked, gpiod_line_settings* settings) : offset(asked.offset) {
    const GpiodChip chip(asked.device);
    const LineConfig lines(made(gpiod_line_config_new()));
    if (gpiod_line_config_add_line_settings(lines.get(), &offset, 1, settings) != 0) fail();
    const RequestConfig config(made(gpiod_request_config_new()));
    gpiod_request_config_set_consumer(config.get(), asked.consumer.c_str());
    gpiod_request_config_set_event_buffer_size(config.get(), kEvents);
    request.reset(made(gpiod_chip_request_lines(chip.chip_, config.get(), lines.get())));
  }
  unsigned offset;
  LineRequest request;
  EventBuffer events;
};

GpiodLine::GpiodLine(std::unique_ptr<Handle> handle) : handle_(std::move(handle)) {}
GpiodLine::GpiodLine(GpiodLine&&) noexcept = default;
GpiodLine::~GpiodLine() = default;

GpiodLine GpiodLine::output(const Request& request, bool active) {
  const Settings settings(made(gpiod_line_settings_new()));
  gpiod_line_settings_set_active_low(settings.get(), request.active_low);
  if (gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT) != 0 ||
      gpiod_line_settings_set_output_value(settings.get(), line_value(active)) != 0) {
    fail();
  }
  return GpiodLine(std::make_unique<Handle>(request, settings.get()));
}

GpiodLine GpiodLine::input(const Request& request, LineBias bias) {
  const Settings settings(made(gpiod_line_settings_new()));
  gpiod_line_settings_set_active_low(settings.get(), request.active_low);
  if (gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT) != 0 ||
      gpiod_line_settings_set_bias(settings.get(), line_bias(bias)) != 0 ||
      gpiod_line_settings_set_edge_detection(settings.get(), GPIOD_LINE_EDGE_BOTH) != 0 ||
      gpiod_line_settings_set_event_clock(settings.get(), GPIOD_LINE_CLOCK_MONOTONIC) != 0) {
    fail();
  }
  auto handle = std::make_unique<Handle>(request, settings.get());
  handle->events.reset(made(gpiod_edge_event_buffer_new(kEvents)));
  if (fcntl(gpiod_line_request_get_fd(handle->request.get()), F_SETFL, O_NONBLOCK) != 0) fail();
  return GpiodLine(std::move(handle));
}

bool GpiodLine::set(bool active) noexcept {
  return gpiod_line_request_set_value(handle_->request.get(), handle_->offset, line_value(active)) == 0;
}

int GpiodLine::descriptor() const noexcept {
  return gpiod_line_request_get_fd(handle_->request.get());
}

std::optional<bool> GpiodLine::get() noexcept {
  const gpiod_line_value value = gpiod_line_request_get_value(handle_->request.get(), handle_->offset);
  return value == GPIOD_LINE_VALUE_ERROR ? std::nullopt : std::optional(value == GPIOD_LINE_VALUE_ACTIVE);
}

int GpiodLine::event_descriptor() const noexcept {
  return gpiod_line_request_get_fd(handle_->request.get());
}

std::size_t GpiodLine::read_edges(std::span<LineEdge> edges) noexcept {
  gpiod_edge_event_buffer* buffer = handle_->events.get();
  const int count =
      gpiod_line_request_read_edge_events(handle_->request.get(), buffer, std::min(kEvents, edges.size()));
  for (int i = 0; i < count; ++i) {
    gpiod_edge_event* event = gpiod_edge_event_buffer_get_event(buffer, static_cast<unsigned long>(i));
    const bool rising = gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE;
    const std::uint64_t ns = gpiod_edge_event_get_timestamp_ns(event);
    edges[static_cast<std::size_t>(i)] = {rising, TimePoint{Duration{static_cast<Duration::rep>(ns)}}};
  }
  return count < 0 ? 0 : static_cast<std::size_t>(count);
}

}  // namespace contourd
