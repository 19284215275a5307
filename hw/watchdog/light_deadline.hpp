// Decides when the light watchdog must turn the light off: takes the daemon's messages and the time, and
// returns the actions that are due. Value type; neither allocates nor throws.
//
// A LightDeadline watches one exposure at a time, from light on's first byte until darkness is confirmed.
// Meanwhile the daemon sends a heartbeat every 50 ms, with the time at which the exposure ends and whether it
// has turned the light off.
#pragma once

#include <cstdint>
#include <optional>

#include "hw/clock.hpp"

namespace contourd {

enum class LightTrip : std::uint32_t {
  None,
  Overrun,  // the exposure is over, and the daemon has not turned the light off
  Silence,  // the daemon sends nothing: it hangs, was stopped, or the machine is too busy
  Death,    // the daemon is gone
};

struct WatchedExposure {
  std::uint64_t number = 0;  // unique, counted from 1
  TimePoint end{};
  bool off_asked = false;  // light off was requested: from then on it is enough that the daemon is alive
};

class LightDeadline {
 public:
  // The light is off 250 ms after the daemon's last sign of life; 50 ms of these allow for waking up late.
  static constexpr Duration kMaxSilence{std::chrono::milliseconds{200}};
  static constexpr Duration kMaxOverrun{std::chrono::milliseconds{250}};
  // Number of light offs that are sent in a row, because a projector ignores commands within its gap.
  static constexpr int kTimes = 3;
  // Interval of the light offs after these, for as long as the daemon is silent.
  static constexpr Duration kAgain{std::chrono::seconds{1}};

  // Sets the time from one light off to the next: a serial projector's gap plus the command's time on the
  // wire.
  void set_gap(Duration gap) { gap_ = gap; }

  // Take the daemon's messages. `sent` is when the daemon sent the message: one that has waited in the socket
  // is no fresh sign of life.
  void arm(const WatchedExposure& exposure, TimePoint sent, TimePoint now);
  void heartbeat(const WatchedExposure& exposure, TimePoint sent, TimePoint now);
  void disarm(std::uint64_t number) {
    if (exposure_ && exposure_->number == number) exposure_.reset();
  }
  // Notes that the daemon is gone for good.
  void daemon_is_gone() { gone_ = true; }

  struct Act {
    bool light_off = false;            // by the line and the serial port
    bool display_black = false;        // after light_off
    LightTrip trip = LightTrip::None;  // to be reported
    bool end = false;                  // ends the process
  };
  // Returns the actions that are due. To be called after every message, and at next().
  [[nodiscard]] Act due(TimePoint now);
  [[nodiscard]] std::optional<TimePoint> next() const;

  // Returns the number of the exposure under watch; 0 if there is none.
  [[nodiscard]] std::uint64_t exposure() const { return exposure_ ? exposure_->number : 0; }

 private:
  [[nodiscard]] LightTrip trip(TimePoint now) const;
  [[nodiscard]] bool tripped() const { return times_ > 0; }
  void send_off(TimePoint now, Act& act);

  std::optional<WatchedExposure> exposure_;  // nullopt while no light is on
  TimePoint heard_{};                        // the last sign of life
  Duration gap_{};
  int times_ = 0;      // number of light offs sent since it tripped
  TimePoint again_{};  // when light off is sent next
  bool gone_ = false;
};

}  // namespace contourd
