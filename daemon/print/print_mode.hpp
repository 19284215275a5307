// A print mode: a way of carrying out prints, such as layer by layer. The queue, the control socket, the
// history and the reports know a print only by this interface. Event loop's thread only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "daemon/frames/frame_record.hpp"
#include "daemon/print/print_plan.hpp"
#include "daemon/print/print_progress.hpp"
#include "daemon/print/print_settings.hpp"
#include "daemon/print/rise_change.hpp"
#include "daemon/print/shown_mask.hpp"
#include "hw/clock.hpp"
#include "hw/enum_names.hpp"

namespace contourd {

// The activities as which a report draws the states.
enum class PrintActivity { Preparing, Exposing, Moving, Waiting, Stopped };
inline constexpr std::size_t kPrintActivities = 5;
[[nodiscard]] std::string_view name_of(PrintActivity activity);

// The causes of a print's time, which forecast and report share. They have the names of the states that they
// consist of.
enum class TimeCause : std::uint8_t {
  WarmingUp,
  Homing,
  Lowering,    // to the height of a layer or rise
  Settling,    // of the resin, before the light
  Light,       // exposures and rises
  Resting,     // between the light and the peel
  Lifting,     // peel and lift
  Recovering,  // of the window, between two rises
  Switching,   // waiting for masks, for the screen and for the projector to answer
  Stopped,     // for the user, with the moves for that
  Parking,
};
template <>
inline constexpr auto kNames<TimeCause> = names_to<TimeCause::Parking>(
    "warming up, homing, lowering, settling, light, resting, lifting, recovering, switching, stopped, "
    "parking");
inline constexpr std::size_t kTimeCauses = kNames<TimeCause>.size();

// The time of a print or of a part of it, by cause.
struct TimeByCause {
  std::array<Duration, kTimeCauses> each{};

  [[nodiscard]] Duration& operator[](TimeCause cause) { return each[static_cast<std::size_t>(cause)]; }
  [[nodiscard]] Duration operator[](TimeCause cause) const { return each[static_cast<std::size_t>(cause)]; }
  [[nodiscard]] Duration total() const { return std::accumulate(each.begin(), each.end(), Duration{}); }
  bool operator==(const TimeByCause&) const = default;
};

// A state of a print. Each mode has its own; the first one is kIdle.
struct PrintState {
  std::size_t number = 0;  // position among the mode's states
  std::string_view name;   // in the status, the metrics, the log and the report
  PrintActivity activity = PrintActivity::Waiting;
  bool logged = false;  // worth a line in the log, because it lasts or the user should know of it
  bool ending = false;  // the print is over, and waits only for the light to be confirmed off
  TimeCause cause = TimeCause::Switching;  // of the time in this state

  friend bool operator==(const PrintState&, const PrintState&) = default;
};

// The point of a pause planned ahead: before this layer, counted from 0, or at this height of the part.
using PausePoint = std::variant<std::int32_t, Nanometers>;
// True if a print pauses for the point before this layer, whose lower side has this height.
[[nodiscard]] bool is_reached(const PausePoint& point, std::int32_t layer, Nanometers bottom);
// Returns "before layer 12" or "at 3.500 mm".
[[nodiscard]] std::string describe(const PausePoint& point);

// Returns a sentence about a plate that met resistance at a height, on its way down to a layer or rise at
// `target`.
[[nodiscard]] std::string describe_resistance(Nanometers met, Nanometers target, const ForcePolicy& force);

// A copy of a model that is to stay dark, by the numbers in the plan's engine.
struct ExcludedCopy {
  std::size_t model = 0, copy = 0;
  // Returns the supports of the other copies; empty if the print has no supports. Called in the dark.
  std::function<std::shared_ptr<const SectionSource>()> supports_left{};
};
// Leaves the copy dark in the plan's masks from a layer on, counted from 0, whose masks are cut at this
// height or above it.
void leave_dark(PrintPlan& plan, const ExcludedCopy& copy, std::int32_t layer, Nanometers from);

// The state while nothing prints.
inline constexpr PrintState kIdle{.name = "idle"};

enum class PrintOutcome { Done, Canceled, Failed };
[[nodiscard]] std::string_view name_of(PrintOutcome outcome);

// The receiver of a print's events. The mode calls it from within its functions, so it must not call back
// into the mode.
class PrintObserver {
 public:
  PrintObserver() = default;
  PrintObserver(const PrintObserver&) = delete;
  PrintObserver& operator=(const PrintObserver&) = delete;
  virtual ~PrintObserver() = default;

  // Called before the light of a layer goes on.
  virtual void light_due() = 0;
  virtual void state_changed(const PrintState& state) = 0;
  virtual void layer_done(const LayerRecord& layer) = 0;
  // Called after the lift of a layer that had all its light, if there is a force line.
  virtual void layer_peeled(std::int32_t /*layer*/, const PeelRecord& /*peel*/) {}
  // Called when the user should know of something that does not interrupt the print.
  virtual void warned(const std::string& /*what*/) {}
  // Called when another mask has replaced one on the screen while the plate rises, or when the rise stops.
  virtual void frame_over(const FrameRecord& /*frame*/) {}
  // Called when a phase of the print begins, with the light off.
  virtual void progressed(const PrintProgress&) {}
  // Called when the print was interrupted: the light was turned off, and layer() waits for resume(). `what`
  // says why.
  virtual void interrupted(const std::string& what) = 0;
  // Called when a light that may have been on until now is confirmed off, or when the print ends without this
  // confirmation.
  virtual void light_gone() = 0;
  // Called when the print is over: the light is off and the mode idle. `reason` says why it failed.
  virtual void print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) = 0;
};

class PrintMode {
 public:
  PrintMode() = default;
  PrintMode(const PrintMode&) = delete;
  PrintMode& operator=(const PrintMode&) = delete;
  virtual ~PrintMode() = default;

  // Starts a print. REQUIRES: !under_way(); the plan has at least one layer, and an exposure.
  virtual void start(PrintPlan plan) = 0;
  // Requests a pause after the layer under way; if the plate already moves up for a pause, withdraws
  // resume().
  virtual void pause() = 0;
  // Plans a pause between two layers, as soon as the point is reached. There is at most one such plan: a new
  // one, pause(), or resume() while nothing has stopped the print, withdraws it. REQUIRES: under_way().
  virtual void pause_at(PausePoint point) = 0;
  // Withdraws a pending pause, or continues a paused or interrupted print; an interrupted layer then gets the
  // light that it still lacks. Does not check that the machine is ready.
  virtual void resume() = 0;
  // Sets the print's settings, but for those of rises, from the next layer on. REQUIRES: under_way(), and
  // none that changes is fixed.
  virtual void set(const PrintSettings& settings) = 0;
  // Returns the rises that are left; nullopt if there are none.
  [[nodiscard]] virtual std::optional<RisesAhead> rises_ahead() const { return std::nullopt; }
  // Changes the rises that are left, from now on: all of those in rises_ahead().
  virtual void change(const ChangedRises& /*rises*/) {}
  // Leaves a copy dark from the next layer on. REQUIRES: under_way(), such a copy, and that they are not
  // fixed.
  virtual void exclude(ExcludedCopy copy) = 0;
  // Turns the light off at once and moves the plate up; the print waits for resume(). `what` says why, in one
  // sentence. Does nothing while no print is under way.
  virtual void interrupt(const std::string& what) = 0;
  // Ends the print: turns the light off at once and moves the plate to its parking height.
  virtual void cancel() = 0;
  // Ends the print at once and leaves the plate where it is.
  virtual void fail(const std::string& reason) = 0;

  // Returns the state, which is kIdle from the end of a print to the start of the next. Valid as long as the
  // program runs.
  [[nodiscard]] virtual const PrintState& state() const = 0;
  [[nodiscard]] bool under_way() const { return state() != kIdle; }
  [[nodiscard]] virtual bool pause_pending() const = 0;
  // Returns the pause planned ahead that has not been reached.
  [[nodiscard]] virtual const std::optional<PausePoint>& planned_pause() const = 0;
  // Returns, in a sentence, why set() may not change a setting now, or exclude() may not be called
  // ("copies"); empty if it may. REQUIRES: under_way().
  [[nodiscard]] virtual std::string_view why_fixed(std::string_view what) const = 0;
  // Returns the settings of the next layer. REQUIRES: under_way().
  [[nodiscard]] virtual PrintSettings settings() const = 0;
  // Returns when a pause that is requested now takes effect, as a text for the user: "after this layer".
  // Empty if the print ends before. REQUIRES: under_way().
  [[nodiscard]] virtual std::string_view next_pause() const = 0;
  // True if resume() has an effect.
  [[nodiscard]] virtual bool can_resume() const = 0;
  // True unless the print ends by itself, and was not cancelled. REQUIRES: under_way().
  [[nodiscard]] virtual bool can_cancel() const = 0;
  // Returns, in a sentence, why the print ends before a pause. REQUIRES: under_way().
  [[nodiscard]] virtual std::string_view why_it_ends() const = 0;
  // Returns what interrupted the print, until it is resumed; empty if nothing did.
  [[nodiscard]] virtual const std::string& interruption() const = 0;
  // True from the light-on command until the light is confirmed off, or the print ends without this
  // confirmation.
  [[nodiscard]] virtual bool light_may_be_on() const = 0;
  // Returns the layer under way, from 0. REQUIRES: under_way(), as for the next two.
  [[nodiscard]] virtual std::int32_t layer() const = 0;
  // Returns the height of the layer's upper side above the plate.
  [[nodiscard]] virtual Nanometers layer_top() const = 0;
  [[nodiscard]] virtual Nanometers layer_thickness() const = 0;
  // Returns the mask that is or was last on the screen; its mask is null before the first layer. Valid until
  // the event loop's next turn.
  [[nodiscard]] virtual ShownMask shown() const = 0;
  // True if the mask is on the screen now, as far as is known.
  [[nodiscard]] virtual bool shows_mask() const = 0;
  // Returns the time from now to the end of the print, with warm-up, homing and parking but without pauses,
  // provided that the layers are as expected. It stops counting down only while a state takes longer than
  // expected or waits for the user. REQUIRES: under_way().
  [[nodiscard]] virtual Duration time_left() const = 0;
  // Returns the time from now to the end of the current state; nullopt if unknown. REQUIRES: under_way().
  [[nodiscard]] virtual std::optional<Duration> state_left() const = 0;
};

}  // namespace contourd
