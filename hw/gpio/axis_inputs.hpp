// The axis' switches, emergency stop, lid, power-fail signal, force line and encoder: the work of the input
// thread, which reads their edges, without its waiting. The input thread halts the steps and cuts the light
// itself where that is urgent, and queues settled changes for the event loop. Its functions neither allocate,
// lock, log nor throw.
//
// The emergency stop, the lid and the power-fail signal are safety inputs. The light is cut at their first
// edge, or when their level cannot be read, and stays cut until they have settled safe and the event loop has
// called let_go(). An emergency stop that lasts also inhibits the steps. If a switch or the force line cannot
// be read, no input can be relied on: see lost().
//
// Invariants of the state that the two threads share:
//  1. Only the input thread increments added_, after writing the entry that it counts. Only the event loop
//     increments taken_, after reading the entry. added_ - taken_ is at most kChanges; a further change loses
//     the inputs instead.
//  2. lost_ stays true once it is.
//  3. The input thread marks an input as unsafe before it cuts the light and inhibits the steps; the event
//     loop checks the inputs again after let_go() has undone both. So whichever acts last leaves the light
//     cut and the steps inhibited while an input is unsafe.
//  4. A halt by the rule Beyond, by the second switch or by force is queued before the steps are halted. A
//     halt by the rule AtContact is queued when the contact has settled, with the time of its first edge.
//  5. Each rule halts once: afterwards the limit rule and the force rule are Never, and the second switch is
//     no longer watched.
//  6. The input thread uses cutoff_ only while cutting_ is set.
#pragma once

#include <poll.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "hw/event_descriptor.hpp"
#include "hw/gpio/contact.hpp"
#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/encoder_edges.hpp"
#include "hw/gpio/step_engine.hpp"
#include "hw/light_line.hpp"

namespace contourd {

enum class AxisInput : std::uint8_t { LimitSwitch, SecondSwitch, EmergencyStop, Lid, PowerFail, Force };
inline constexpr std::size_t kAxisInputs = 6;

// A change of the inputs: a switch has settled, or a safety input's state has changed.
struct InputChange {
  AxisInput which = AxisInput::LimitSwitch;
  bool active = false;
  bool halted = false;                                           // the steps were halted because of it
  TimePoint at{};                                                // the first edge to this level
  SafetyState from = SafetyState::Safe, to = SafetyState::Safe;  // for a safety input
  bool readable = true;                                          // for a safety input
};

// The condition under which the limit switch halts the steps.
enum class LimitRule : std::uint8_t {
  Never,
  AtContact,  // at its first edge, for homing
  Beyond,     // when it has settled closed at a position where it should be open
};

// The condition under which a settled force brings the steps to rest (StepEngine::brake_soon()).
enum class ForceRule : std::uint8_t {
  Never,
  Above,   // while the position is above a limit
  Beyond,  // once the motor has moved down by a distance under this force
};

class AxisInputs {
 public:
  struct Contact {
    InputLine* line = nullptr;  // not owned; null if there is none
    Duration debounce{};
  };
  struct Lines {
    std::array<Contact, kAxisInputs> contacts;  // by AxisInput
    InputLine *encoder_a = nullptr, *encoder_b = nullptr, *encoder_index = nullptr;
  };

  // Reads every level. The engine and the lines must outlive this object. Throws std::system_error (an
  // eventfd).
  AxisInputs(StepEngine& engine, const Lines& lines, StepEngine::Now now = monotonic_now);

  // Functions for the event loop's thread.

  // Sets the limit switch's rule; it halts at most once. For the rule Beyond, `limit` is the last position at
  // which the switch may be closed: it may be closed below or, with `from_above`, above this position.
  void set_limit_rule(LimitRule rule, std::int64_t limit = 0, bool from_above = false) noexcept;
  // Sets whether the second switch halts the steps when it has settled closed.
  void watch_second_switch(bool watched) noexcept;
  // Sets the force's rule, with the limit of its position or the distance; it halts at most once.
  void set_force_rule(ForceRule rule, std::int64_t limit = 0) noexcept;
  // Sets the light that is cut; null for none. The previous one is no longer used when this has returned.
  void set_light_cutoff(LightCutoff* cutoff) noexcept;
  // Allows steps and light again, unless an input is unsafe by now.
  void let_go() noexcept;
  // True if a switch is closed, a force has settled, or a safety input is not safe.
  [[nodiscard]] bool active(AxisInput which) const noexcept { return active_[index(which)]; }
  // True if a safety input has had an edge and it is not known yet whether the change lasts.
  [[nodiscard]] bool debouncing(AxisInput which) const noexcept {
    return states_[index(which)] == SafetyState::Debouncing;
  }
  [[nodiscard]] bool readable(AxisInput which) const noexcept { return !unreadable_[index(which)]; }
  [[nodiscard]] std::uint64_t edges(AxisInput which) const noexcept { return edges_[index(which)]; }
  [[nodiscard]] std::optional<InputChange> take_change() noexcept;
  // Returns a descriptor that is readable when there are changes to take.
  [[nodiscard]] EventDescriptor& changes() noexcept { return changed_; }
  // True if the inputs can no longer be relied on: changes came faster than they were taken, a switch cannot
  // be read, or a line's chip is gone. The steps are inhibited and the light is cut.
  [[nodiscard]] bool lost() const noexcept { return lost_; }
  // Returns the count, which rises while A leads B.
  [[nodiscard]] std::int64_t encoder_count() const noexcept { return count_; }
  [[nodiscard]] std::uint64_t illegal_encoder_edges() const noexcept { return illegal_; }
  // Returns the number of edges of one of the encoder's lines.
  [[nodiscard]] std::uint64_t encoder_edges(EncoderLine which) const noexcept {
    return encoder_edges_[static_cast<std::size_t>(which)];
  }
  // The number of passes of the encoder's index, and the count at the last pass or at a later one.
  struct IndexPulse {
    std::uint64_t number = 0;
    std::int64_t count = 0;
  };
  [[nodiscard]] IndexPulse index_pulse() const noexcept {
    const std::uint64_t number = index_pulses_;
    return {number, index_count_};
  }

  // Functions for the input thread.

  // Returns a descriptor that is readable when the rules have changed.
  [[nodiscard]] EventDescriptor& work() noexcept { return work_; }
  // Reads all pending edges and acts on them. Returns the time of the next call, which is needed even without
  // edges; nullopt if only edges require one.
  std::optional<TimePoint> serve() noexcept;
  // Returns the descriptors to wait for: those of the lines, and work().
  static constexpr std::size_t kDescriptors = kAxisInputs + 4;
  [[nodiscard]] std::array<pollfd, kDescriptors> descriptors() const noexcept;
  // To be called when a descriptor has failed because its chip is gone. lost() is true then.
  void lose() noexcept;

 private:
  [[nodiscard]] static std::size_t index(AxisInput which) { return static_cast<std::size_t>(which); }
  void take_edges(AxisInput which) noexcept;
  void read_levels(TimePoint now) noexcept;
  void at_edge(AxisInput which, const LineEdge& edge) noexcept;
  void at_switch_edge(AxisInput which, const LineEdge& edge) noexcept;
  void settle_switch(AxisInput which, TimePoint now) noexcept;
  void settle_safety(AxisInput which, TimePoint now) noexcept;
  [[nodiscard]] bool level_of(AxisInput which) noexcept;
  [[nodiscard]] bool look_at(AxisInput which) noexcept;
  [[nodiscard]] bool last_level(AxisInput which) const noexcept;
  void put(AxisInput which, SafetyState state) noexcept;
  [[nodiscard]] bool unsafe() const noexcept {
    return lost_ || active(AxisInput::EmergencyStop) || active(AxisInput::Lid) ||
           active(AxisInput::PowerFail);
  }
  void cut_light() noexcept;
  void release_light() noexcept;
  void cut_again(TimePoint now) noexcept;
  [[nodiscard]] std::optional<TimePoint> next_due() const noexcept;
  void apply_rules() noexcept;
  [[nodiscard]] bool meets_resistance() noexcept;
  void add_change(const InputChange& change) noexcept;
  [[nodiscard]] bool out_of_place(std::int64_t position) const noexcept {
    return from_above_ ? position < limit_ : position > limit_;
  }
  [[nodiscard]] bool watching() const noexcept;

  StepEngine& engine_;
  Lines lines_;
  StepEngine::Now now_;
  EventDescriptor work_, changed_;

  std::atomic<LimitRule> limit_rule_{LimitRule::Never};
  std::atomic<std::int64_t> limit_{0};
  std::atomic<bool> from_above_{false}, second_watched_{false}, lost_{false};
  std::atomic<ForceRule> force_rule_{ForceRule::Never};
  std::atomic<std::int64_t> force_limit_{0};
  std::array<std::atomic<bool>, kAxisInputs> active_{}, unreadable_{};
  std::array<std::atomic<SafetyState>, kAxisInputs> states_{};  // used for the safety inputs
  std::array<std::atomic<std::uint64_t>, kAxisInputs> edges_{};
  std::array<std::atomic<std::uint64_t>, kEncoderLines> encoder_edges_{};
  std::atomic<LightCutoff*> cutoff_{nullptr};
  std::atomic<bool> cutting_{false};  // the input thread is using cutoff_
  std::atomic<std::int64_t> count_{0};
  std::atomic<std::uint64_t> illegal_{0}, index_pulses_{0};
  std::atomic<std::int64_t> index_count_{0};

  // A spike on a safety input makes three changes and mains hum makes 50 spikes a second, so there is room
  // for more than a second of hum.
  static constexpr std::uint32_t kChanges = 256;
  std::array<InputChange, kChanges> ring_{};
  std::atomic<std::uint32_t> added_{0}, taken_{0};

  // Members of the input thread.
  std::array<Debounce, kAxisInputs> switches_;
  std::array<SafetyContact, kAxisInputs> safety_;
  std::array<bool, kAxisInputs> halted_{};  // in this bout of edges
  std::optional<TimePoint> cut_again_at_;
  EncoderEdges encoder_;
  TimePoint levels_read_{}, served_{};
  std::optional<std::int64_t> pressed_from_;  // the position at which the rule Beyond found the force
};

}  // namespace contourd
