// How far a print is in its rises, and what follows. A value; not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/print/print_plan.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Returns the plan with no speed above `most`. A plan that keeps the laws of a rise keeps them then, too:
// they allow every speed below one that they allow, and the gap that resin flows through gets no narrower
// than it is at `most`. REQUIRES: a plan with points; `most` is positive.
[[nodiscard]] RisePlan capped(const RisePlan& plan, MillimetersPerSecond most);

// The next part of a print, after the present one.
enum class NextPart : std::uint8_t {
  Layers,
  Rest,  // before a rise
  Rise,  // the next one, or the rest of the one under way
};

class RiseProgress {
 public:
  RiseProgress() = default;
  // Starts a print, in layers. Rises that begin beneath `from` are over: the print goes on from there.
  RiseProgress(std::vector<PlannedRise> rises, Nanometers from);

  // True until the last rise is over.
  [[nodiscard]] bool any_left() const { return at_ < rises_.size(); }
  // Notes that the print has reached the next rise in layers. REQUIRES: any_left().
  void reach();
  // Begins the next rise, unless it has begun. REQUIRES: next() is not Layers.
  void begin();
  // True while a rise is under way.
  [[nodiscard]] bool begun() const { return begun_; }
  // Returns the rise under way, or else the next one. REQUIRES: any_left().
  [[nodiscard]] const PlannedRise& current() const;
  // Returns what is left of the rise. REQUIRES: begun(), as for the next one.
  [[nodiscard]] const RisePlan& rest() const;
  // Notes that the plate has come to rest at a height within the rise. Ends the rise if what is left is not
  // worth a motion.
  void stop_at(Nanometers height);

  // Slows the rise down, and all rises after it, to three quarters of the planned speed around a height, but
  // not below `slowest`. The rise under way is slower from the next call of stop_at() on.
  // False, and nothing changed, if the rise cannot be slower, or was slowed down less than a second ago.
  // REQUIRES: begun(); a height within the rise.
  bool slow_down(Nanometers height, MillimetersPerSecond slowest, TimePoint now);
  // Returns the time that what is left of the rise takes if it is slowed down as far as that goes. REQUIRES:
  // begun().
  [[nodiscard]] Duration longest(MillimetersPerSecond slowest) const;
  // Returns the part that follows. There may be no layers above the last rise.
  [[nodiscard]] NextPart next() const;
  // Returns the time at which the rest before the next rise is over, which it began at `now` or before.
  // REQUIRES: any_left().
  [[nodiscard]] TimePoint rest_until(TimePoint now);

 private:
  std::vector<PlannedRise> rises_;
  std::size_t at_ = 0;  // index in rises_: the rise under way, or else the next
  bool begun_ = false;
  RisePlan rest_;                            // of the rise under way
  std::optional<MillimetersPerSecond> cap_;  // once the print was slowed down
  TimePoint slowed_at_{};
  Nanometers here_{};                    // the height up to which the print has whole parts
  std::optional<TimePoint> rest_until_;  // once the rest has begun
};

}  // namespace contourd
