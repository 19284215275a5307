// How far a print is in its rises, and what follows. A value; not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "daemon/print/print_plan.hpp"
#include "daemon/print/rise_change.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Returns the plan with no speed above `most`. A plan that keeps the laws of a rise keeps them then, too:
// they allow every speed below one that they allow, and the gap that resin flows through gets no narrower
// than it is at `most`. REQUIRES: a plan with points; `most` is positive.
[[nodiscard]] RisePlan capped(const RisePlan& plan, MillimetersPerSecond most);

// Returns the plate's way in a rise to the end of its overrun: from its bottom, or from where the rise before
// ended, if that is higher. REQUIRES: a plan with points.
[[nodiscard]] RisePlan way_of(const RisePlan& plan, Nanometers from);
// Returns the height at which the rise before ends, with its overrun, if this one begins on top of it without
// layers between them; 0 if not. REQUIRES: an index of the rises.
[[nodiscard]] Nanometers end_beneath(std::span<const PlannedRise> rises, std::size_t at);

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
  RiseProgress(PlannedRises rises, Nanometers from);

  // True if the print has rises.
  [[nodiscard]] bool planned() const { return !rises_.each.empty(); }
  // True until the last rise is over.
  [[nodiscard]] bool any_left() const { return at_ < rises_.each.size(); }
  // Notes that the print has reached the next rise in layers. REQUIRES: any_left().
  void reach();
  // Begins the next rise, unless it has begun. REQUIRES: next() is not Layers.
  void begin();
  // True while a rise is under way.
  [[nodiscard]] bool begun() const { return begun_; }
  // Returns the rise under way, or else the next one. REQUIRES: any_left().
  [[nodiscard]] const PlannedRise& current() const;
  // Returns what is left of the plate's way, see way_of(). REQUIRES: begun(), as for the next one.
  [[nodiscard]] const RisePlan& rest() const;
  // Notes that the plate has come to rest at a height within the rise. Ends the rise if what is left is not
  // worth a motion.
  void stop_at(Nanometers height);

  // Slows the rise down, and all rises after it, to three quarters of the planned speed around a height, but
  // not below `slowest`. The rise under way is slower from the next call of stop_at() on.
  // False, and nothing changed, if the rise cannot be slower, or was slowed down less than a second ago.
  // REQUIRES: begun(); a height within the rise.
  bool slow_down(Nanometers height, MillimetersPerSecond slowest, TimePoint now);
  // Returns what a change of the settings is planned from, with the plate at a height of the rise under way.
  // REQUIRES: any_left(), and that the rises can be changed.
  [[nodiscard]] RisesAhead ahead(std::optional<Nanometers> height) const;
  // Changes the rise under way, from the next call of stop_at() on if the plate moves, and all rises after
  // it. A new speed replaces that of slow_down(). REQUIRES: as many rises as are left.
  void change(const ChangedRises& changed, TimePoint now);
  // True for three seconds after a change within a rise: each one stops the plate in the light, and it has to
  // rise between two.
  [[nodiscard]] bool just_changed(TimePoint now) const;
  // Counts light of the rise under way, which uses up the window's oxygen.
  void add_light(Duration light) { lit_ += light; }
  // True from a change within a rise until the plate has come to rest.
  [[nodiscard]] bool is_changed() const { return changed_; }
  // True if the plan says what the speeds follow from.
  [[nodiscard]] bool can_change() const { return rises_.slabs != nullptr; }
  [[nodiscard]] const RiseSettings& settings() const { return rises_.settings; }
  // Returns the time that what is left of the rise takes if it is slowed down as far as that goes. REQUIRES:
  // begun().
  [[nodiscard]] Duration longest(MillimetersPerSecond slowest) const;
  // Returns the part that follows. There may be no layers above the last rise.
  [[nodiscard]] NextPart next() const;
  // Returns the time at which the rest before the next rise is over, which it began at `now` or before.
  // REQUIRES: any_left().
  [[nodiscard]] TimePoint rest_until(TimePoint now);

 private:
  PlannedRises rises_;
  std::size_t at_ = 0;  // index of the rise under way, or else the next
  bool begun_ = false, changed_ = false;
  RisePlan rest_;                            // of the rise under way
  std::optional<MillimetersPerSecond> cap_;  // once the print was slowed down
  TimePoint slowed_at_{};
  std::optional<TimePoint> changed_at_;  // the last change within the rise under way
  Duration lit_{};                       // of the rise under way
  Nanometers here_{};                    // the height up to which the print has whole parts
  Nanometers plate_{};                   // where the last rise ended, until layers follow it
  std::optional<TimePoint> rest_until_;  // once the rest has begun
};

}  // namespace contourd
