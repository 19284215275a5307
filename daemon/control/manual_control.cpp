#include "daemon/control/manual_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <utility>

#include "core/image/test_pattern.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

using Json = ManualControl::Json;

namespace {

constexpr double kLongestPictureS = 600;
constexpr const char* kBytesInWords = "bytes in Base64";

bool is_set(const Json& given, const char* name) {
  return given.value(name, false);
}

Duration seconds(double number) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(number));
}

std::vector<std::string> pattern_names() {
  std::vector<std::string> names;
  for (const TestPattern pattern : kTestPatterns)
    names.emplace_back(name_of(pattern));
  return names;
}

// Returns the maximum size of a picture's PNG file in bytes: nearly uncompressed, plus metadata.
std::size_t largest_picture(const MaskDisplay& display) {
  constexpr std::size_t kMetadata = 65'536;
  const std::size_t pixels =
      static_cast<std::size_t>(display.width().count()) * static_cast<std::size_t>(display.height().count());
  return pixels + pixels / 8 + kMetadata;
}

double millimetres(Nanometers height) {
  return to_millimeters(height).count();
}

std::vector<ControlParameter> motion_parameters(const PrinterContext& context,
                                                const ControlParameter& plate_is_clear) {
  constexpr double kSlowest = 0.01;
  const double travel = millimetres(context.machine.z_axis().travel());
  const double top_speed = context.config.top_speed.value_or(context.config.travel_speed).count();
  return {
      ControlParameter::number("to_mm", 0, travel, "mm", "height above the film, within the axis' travel"),
      ControlParameter::number("by_mm", -travel, travel, "mm",
                               "distance upwards, instead of a height; with `unhomed` from -2 to 2"),
      ControlParameter::number("speed_mm_s", kSlowest, top_speed, "mm/s",
                               "speed, by default the configuration's travel speed"),
      ControlParameter::flag("unhomed", "true to move slowly from an unknown position"), plate_is_clear};
}

}  // namespace

std::size_t PictureUpload::add(std::uint64_t connection, std::size_t from,
                               std::span<const std::uint8_t> piece) {
  if (from == 0) {
    drop(connection_);
    connection_ = connection;
  }
  if (connection != connection_ || from != bytes_.size()) {
    throw ControlRefusal(
        fmt::format("the piece at {} does not continue this connection's picture, which has {} bytes so "
                    "far: start again at 0",
                    from, connection == connection_ ? bytes_.size() : 0));
  }
  if (piece.size() > most_ - bytes_.size()) {
    drop(connection);
    throw ControlRefusal(fmt::format("a picture has at most {} bytes", most_));
  }
  bytes_.insert(bytes_.end(), piece.begin(), piece.end());
  return bytes_.size();
}

std::vector<std::uint8_t> PictureUpload::take(std::uint64_t connection) {
  if (connection != connection_ || bytes_.empty())
    throw ControlRefusal(
        "no picture was uploaded by this connection, or another connection's upload replaced it");
  connection_ = 0;
  return std::exchange(bytes_, {});
}

void PictureUpload::drop(std::uint64_t connection) {
  if (connection != connection_) return;
  connection_ = 0;
  bytes_ = {};
}

ManualControl::ManualControl(const PrinterContext& context, const Parts& parts, ManualProcess& process,
                             Worker& worker)
    : context_(context),
      parts_(parts),
      process_(process),
      worker_(worker),
      upload_(largest_picture(context.machine.display())) {}

ControlMethods ManualControl::methods() {
  using Parameter = ControlParameter;
  const Parameter plate_is_clear = Parameter::flag("plate_is_clear", "true if nothing is in the plate's way");
  const double light_limit = std::chrono::duration<double>(context_.config.manual.light_limit).count();
  return {
      {"home",
       begins("Homes the plate: it moves to its limit switch.", &ManualControl::home, {plate_is_clear})},
      {"move", begins("Moves the plate to a height above the film, or by a distance.", &ManualControl::move,
                      motion_parameters(context_, plate_is_clear))},
      {"stop", ends("Ends the manual operation: the motor slows down to rest, the light goes off, the screen "
                    "is black.",
                    &ManualControl::stop)},
      {"motor_off", begins("Turns off the motor's current. The plate's position is then unknown.",
                           &ManualControl::motor_off, {})},
      {"light_on",
       begins("Turns the light on for some seconds, with the current picture.", &ManualControl::light_on,
              {Parameter::number("seconds", 0.001, light_limit, "s",
                                 "duration; `manual.light_limit_s` of the configuration is the limit")
                   .needed(),
               Parameter::flag("in_resin", "true to allow light while the plate may be in the resin")})},
      {"light_off", ends("Turns the light off.", &ManualControl::light_off)},
      {"show",
       {.description = "Shows a test pattern, or the picture that this connection has uploaded.",
        .parameters =
            {Parameter::one_of("pattern", pattern_names(), "the pattern; needed unless `uploaded` is true"),
             Parameter::flag("uploaded", "true for the uploaded picture, reported as `picture`"),
             Parameter::number("seconds", 0.001, kLongestPictureS, "s", "duration, by default the longest")},
        .changes = true,
        .needs_service_rights = true,
        .call_later = [this](const Json& given, const ControlCaller& caller,
                             ControlMethod::Later later) { return show(given, caller, std::move(later)); }}},
      // An upload alone changes nothing on the printer.
      {"upload",
       {.description = "Uploads a piece of a picture: a PNG file of 8-bit grey and the display's size.",
        .parameters = {Parameter::whole_number(
                           "from", 0, Parameter::kMost,
                           "position of the piece: the number of bytes uploaded before; 0 "
                           "starts a new picture")
                           .described_as("a whole number")
                           .needed(),
                       Parameter::text("data", "the piece").described_as(kBytesInWords).needed()},
        .call = [this](const Json& given, const ControlCaller& caller) { return upload(given, caller); },
        .needs_service_rights = true}},
      {"projector", begins("Turns the projector's power on, and waits until it is warm, or off; without "
                           "parameters, queries the "
                           "projector's state.",
                           &ManualControl::projector,
                           {Parameter::one_of("power", {"on", "off"}, "the projector's power")})},
      {"inputs",
       {.description = "Reads the current inputs of the axis: the switches, the emergency stop, the lid, the "
                       "power-fail signal, the force line and the encoder's lines, if they are fitted.",
        .call = [this](const Json&, const ControlCaller&) { return inputs(); }}}};
}

ControlMethod ManualControl::begins(const char* description,
                                    Json (ManualControl::*method)(const Json&, const ControlCaller&),
                                    std::vector<ControlParameter> parameters) {
  return {.description = description,
          .parameters = std::move(parameters),
          .call = [this, method](const Json& given,
                                 const ControlCaller& caller) { return (this->*method)(given, caller); },
          .changes = true,
          .needs_service_rights = true};
}

ControlMethod ManualControl::ends(const char* description, Json (ManualControl::*method)()) {
  return {.description = description,
          .call = [this, method](const Json&, const ControlCaller&) { return (this->*method)(); },
          .changes = true};
}

void ManualControl::disconnected(std::uint64_t connection) {
  if (std::exchange(operation_owner_, operation_owner_ == connection ? 0 : operation_owner_) == connection)
    process_.stop();
  if (std::exchange(picture_owner_, picture_owner_ == connection ? 0 : picture_owner_) == connection)
    process_.hide();
  if (reading_for_ == connection) reading_for_ = 0;
  upload_.drop(connection);
}

// --- conditions

void ManualControl::require_no_print(const std::string& instead) const {
  if (parts_.job.job() != nullptr)
    throw ControlRefusal(fmt::format("{} is being printed: {}", printable(parts_.job.name()), instead));
}

void ManualControl::require_free() const {
  require_no_print("the printer is controlled by hand while nothing prints");
  if (parts_.scheduler.claiming()) throw ControlRefusal("the next job is about to begin");
  if (process_.state() != ManualState::Idle) {
    throw ControlRefusal(
        fmt::format("the printer is already controlled by hand ({}): stop ends the operation",
                    name_of(process_.state())));
  }
}

// Light and motion exclude each other.
void ManualControl::require_motion_allowed() const {
  require_free();
  const std::vector<std::string> troubles = context_.machine.z_axis().why_not_ready();
  if (!troubles.empty())
    throw ControlRefusal(fmt::format("the plate cannot be moved: {}", fmt::join(troubles, "; ")));
  const std::string lit = context_.machine.projector().light_off_unconfirmed();
  if (!lit.empty()) throw ControlRefusal("the plate is not moved because the light may be on: " + lit);
}

void ManualControl::require_way_down(const Json& given) const {
  if (is_set(given, "plate_is_clear")) return;
  const std::string why = parts_.hold.plate_occupant()
                              ? fmt::format("{} is on the plate", printable(*parts_.hold.plate_occupant()))
                              : parts_.hold.sentence();
  if (why.empty()) return;
  throw ControlRefusal(
      fmt::format("the plate is not lowered: {}; add plate_is_clear if nothing is in its way", why));
}

MillimetersPerSecond ManualControl::speed_of(const Json& given) const {
  return MillimetersPerSecond{given.value("speed_mm_s", context_.config.travel_speed.count())};
}

Nanometers ManualControl::target_of(const Json& given) const {
  if (given.contains("to_mm") == given.contains("by_mm"))
    throw InvalidParameters("move takes either to_mm or by_mm");
  const ZAxis& axis = context_.machine.z_axis();
  const std::optional<Nanometers> height = axis.height();
  if (!height) throw ControlRefusal("the plate's position is unknown: home first");
  const double top = millimetres(axis.travel()), now = millimetres(*height);
  const double target =
      given.contains("to_mm") ? given["to_mm"].get<double>() : now + given["by_mm"].get<double>();
  // The rounding error is less than a step.
  constexpr double kRounding = 1e-6;
  if (target < -kRounding || target > top + kRounding)
    throw ControlRefusal(
        fmt::format("the plate cannot go to {:.3f} mm: it is at {:.3f} mm and goes from 0 to "
                    "{:g} mm",
                    target, now, top));
  return std::clamp(to_nanometers(Millimeters{target}).value_or(*height), Nanometers{0}, axis.travel());
}

// --- the methods

Json ManualControl::begun_by(const ControlCaller& caller) {
  operation_owner_ = process_.state() == ManualState::Idle ? 0 : caller.connection;
  return parts_.status.status();
}

Json ManualControl::home(const Json& given, const ControlCaller& caller) {
  require_motion_allowed();
  require_way_down(given);
  parts_.hold.interrupted_moves(std::nullopt);
  process_.home(context_.config.homing_speed);
  return begun_by(caller);
}

Json ManualControl::move(const Json& given, const ControlCaller& caller) {
  if (is_set(given, "unhomed")) return move_unhomed(given, caller);
  require_motion_allowed();
  const Nanometers target = target_of(given);
  const MillimetersPerSecond speed = speed_of(given);
  if (target < context_.machine.z_axis().height()) require_way_down(given);
  parts_.hold.interrupted_moves(std::nullopt);
  process_.move_to(target, speed);
  return begun_by(caller);
}

// Before homing it is not known which direction is down, so a part on the plate forbids both.
Json ManualControl::move_unhomed(const Json& given, const ControlCaller& caller) {
  require_motion_allowed();
  if (given.contains("to_mm") || given.contains("speed_mm_s") || !given.contains("by_mm"))
    throw InvalidParameters("unhomed takes by_mm, but neither to_mm nor speed_mm_s");
  const double most = millimetres(kLongestNudge), distance = given["by_mm"].get<double>();
  if (std::abs(distance) > most)
    throw InvalidParameters(
        fmt::format("by_mm must be a number from {:g} to {:g} mm without a known position", -most, most));
  require_way_down(given);
  const MillimetersPerSecond slow{context_.config.homing_speed.count() / 2};
  const Nanometers way = to_nanometers(Millimeters{distance}).value_or(Nanometers{});
  parts_.hold.interrupted_moves(way);
  process_.nudge(way, std::min(slow, kNudgeSpeed));
  return begun_by(caller);
}

Json ManualControl::motor_off(const Json&, const ControlCaller&) {
  require_free();
  if (!context_.machine.z_axis().release())
    throw ControlRefusal("the motor stays on: no enable line is configured, or the line cannot be set");
  parts_.hold.interrupted_moves(std::nullopt);
  return parts_.status.status();
}

Json ManualControl::light_on(const Json& given, const ControlCaller& caller) {
  require_free();
  if (const std::string not_ready = context_.machine.why_not_ready(); !not_ready.empty())
    throw ControlRefusal("the light stays off: " + printable(not_ready));
  const std::optional<Nanometers> height = context_.machine.z_axis().height();
  const Nanometers depth = context_.config.manual.vat_depth;
  if (!is_set(given, "in_resin") && (!height || *height < depth)) {
    throw ControlRefusal(
        fmt::format("the light stays off: the plate is {}, and below {:g} mm it may be in the resin; "
                    "add in_resin to allow that",
                    height ? fmt::format("at {:.3f} mm", millimetres(*height)) : "at an unknown height",
                    millimetres(depth)));
  }
  process_.light_on(seconds(given["seconds"].get<double>()));
  return begun_by(caller);
}

Json ManualControl::light_off() {
  require_no_print("cancel or pause turns its light off");
  if (process_.light_may_be_on()) process_.stop();
  context_.machine.projector().light_off();
  return parts_.status.status();
}

Json ManualControl::stop() {
  require_no_print("cancel ends the print");
  process_.stop();
  process_.hide();
  return parts_.status.status();
}

void ManualControl::show(const Json& given, const ControlCaller& caller, ControlMethod::Later later) {
  require_display();
  const Duration time = seconds(given.value("seconds", kLongestPictureS));
  if (is_set(given, "uploaded")) {
    if (given.contains("pattern")) throw InvalidParameters("show takes either pattern or uploaded");
    return read_uploaded(caller, time, std::move(later));
  }
  // Without `uploaded` the pattern is needed, and check() has accepted it if it is given.
  const std::string name = given.value("pattern", "");
  const std::optional<TestPattern> pattern = find_test_pattern(name);
  if (!pattern)
    throw InvalidParameters(fmt::format("pattern must be one of {}", fmt::join(pattern_names(), ", ")));
  const MaskDisplay& display = context_.machine.display();
  later(present(draw_test_pattern(*pattern, display.width(), display.height(), context_.config.pixel_pitch),
                name, time, caller));
}

void ManualControl::require_display() const {
  require_no_print("the printer is controlled by hand while nothing prints");
  if (process_.light_may_be_on()) throw ControlRefusal("the light is on: the picture stays as it is");
  const std::vector<std::string> troubles = context_.machine.display().why_not_ready();
  if (!troubles.empty())
    throw ControlRefusal(fmt::format("nothing can be shown: {}", fmt::join(troubles, "; ")));
}

// Decodes the uploaded picture and shows it. Replaces another picture that is still being decoded.
void ManualControl::read_uploaded(const ControlCaller& caller, Duration time, ControlMethod::Later later) {
  struct Read {
    std::optional<Mask> picture;
    std::string trouble;
  };
  const MaskDisplay& display = context_.machine.display();
  const auto read = [bytes = upload_.take(caller.connection), width = display.width(),
                     height = display.height()] {
    try {
      return Read{decode_png(bytes, width, height), ""};
    } catch (const std::exception& error) {
      return Read{std::nullopt, error.what()};
    }
  };
  reading_for_ = caller.connection;
  worker_.run(read, [this, caller, time, later = std::move(later)](Read done) {
    try {
      if (!done.picture) throw ControlRefusal("nothing is shown: " + done.trouble);
      if (std::exchange(reading_for_, 0) != caller.connection)
        throw ControlRefusal("nothing is shown: another picture was requested meanwhile");
      require_display();
      later(present(std::move(*done.picture), "picture", time, caller));
    } catch (const ControlRefusal& refusal) {
      later(refusal);
    }
  });
}

Json ManualControl::upload(const Json& given, const ControlCaller& caller) {
  require_no_print("the printer is controlled by hand while nothing prints");
  const auto piece = from_base64(given["data"].get_ref<const std::string&>());
  if (!piece) throw InvalidParameters(fmt::format("data must be {}", kBytesInWords));
  return {{"bytes", upload_.add(caller.connection, given["from"].get<std::size_t>(), *piece)}};
}

Json ManualControl::present(Mask picture, const std::string& name, Duration time,
                            const ControlCaller& caller) {
  try {
    process_.show(std::move(picture), name, time);
  } catch (const std::filesystem::filesystem_error& error) {
    throw ControlRefusal(fmt::format("nothing is shown: {}", printable(error.what())));
  }
  picture_owner_ = caller.connection;
  return parts_.status.status();
}

Json ManualControl::projector(const Json& given, const ControlCaller& caller) {
  require_free();
  const std::string power = given.value("power", "");
  if (power == "on")
    process_.power_on();
  else if (power == "off")
    process_.power_off();
  else
    process_.ask_status();
  return begun_by(caller);
}

Json ManualControl::inputs() const {
  require_no_print("the inputs are read while nothing prints");
  Json inputs = Json::array();
  for (const AxisInputState& input : context_.machine.z_axis().inputs()) {
    inputs.push_back({{"name", input.name},
                      {"line", input.line},
                      {"active", or_null(input.active)},
                      {"edges", input.edges}});
  }
  return {{"inputs", inputs}};
}

}  // namespace contourd
