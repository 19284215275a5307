// When the light watchdog has to turn the light off: what it is told and the time go in, what is to be done
// comes out. Value type; neither allocates nor throws.
//
// It watches over one exposure at a time, from light on's first byte until darkness is confirmed. Meanwhile
// the daemon tells every 50 ms that it lives, when the exposure ends, and whether it has turned the light
// off.
#pragma once

#include <cstdint>
#include <optional>

#include "hw/clock.hpp"

namespace contourd {

enum class LightTrip : std::uint32_t {
  None,
  Overrun,  // the exposure is over, and the daemon has not turned the light off
  Silence,  // the daemon says nothing: it hangs, was stopped, or the machine is too busy
  Death,    // the daemon is gone
};

struct WatchedExposure {
  std::uint64_t number = 0;  // each has its own, counted from 1
  TimePoint end{};
  bool off_asked = false;  // light off was asked for: from then on it is enough that the daemon lives
};

class LightDeadline {
 public:
  // The light is off 250 ms after the daemon's last sign of life; 50 ms of these are for being woken late.
  static constexpr Duration kMaxSilence{std::chrono::milliseconds{200}};
  static constexpr Duration kMaxOverrun{std::chrono::milliseconds{250}};
  // Light off is told this often in a row: a projector ignores what comes within its gap.
  static constexpr int kTimes = 3;
  // And then again, for as long as the daemon is silent.
  static constexpr Duration kAgain{std::chrono::seconds{1}};

  // From one light off to the next: a serial projector's gap and the command's time on the wire.
  void set_gap(Duration gap) { gap_ = gap; }

  // `sent` is when the daemon sent it: what has lain about is no sign of life.
  void arm(const WatchedExposure& exposure, TimePoint sent, TimePoint now);
  void heartbeat(const WatchedExposure& exposure, TimePoint sent, TimePoint now);
  void disarm(std::uint64_t number);
  // For good.
  void daemon_is_gone() { gone_ = true; }

  struct Act {
    bool light_off = false;            // by the line and the serial port
    bool display_black = false;        // after that
    LightTrip trip = LightTrip::None;  // to be told
    bool end = false;                  // of the process
  };
  // What is due. To be called after every message, and at next().
  [[nodiscard]] Act due(TimePoint now);
  [[nodiscard]] std::optional<TimePoint> next() const;

  // 0 when there is none.
  [[nodiscard]] std::uint64_t exposure() const { return exposure_ ? exposure_->number : 0; }

 private:
  [[nodiscard]] LightTrip trip(TimePoint now) const;
  [[nodiscard]] bool tripped() const { return times_ > 0; }
  void tell_off(TimePoint now, Act& act);

  std::optional<WatchedExposure> exposure_;  // nothing: no light is on
  TimePoint heard_{};                        // the last sign of life
  Duration gap_{};
  int times_ = 0;      // that light off was told since it tripped
  TimePoint again_{};  // when it is told next
  bool gone_ = false;
};

}  // namespace contourd
