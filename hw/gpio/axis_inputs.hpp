// The axis' switches, emergency stop, lid and encoder: what the thread that reads their edges does, without
// the waiting. It halts the steps and cuts the light itself where that cannot wait, and tells the owner (the
// event loop) what has settled. What runs on the thread neither allocates, locks, logs nor throws.
//
// The emergency stop and the lid are safety inputs: the light is cut at their first edge, or when their level
// cannot be read, and stays so until they have settled safe and the owner has let it go. An emergency stop
// that lasts inhibits the steps, too. A switch that cannot be read leaves nothing to be known of the inputs:
// see lost().
//
// Invariants of what the two threads share:
//  1. Only the thread raises told_, behind the entry that it counts; only the owner raises taken_, behind
//     having read it. told_ - taken_ is kChanges at most: one more change loses the inputs instead.
//  2. lost_ stays true once it is.
//  3. The thread says that an input is unsafe before it cuts and inhibits; the owner looks again after
//  letting
//     go. So whoever is last leaves the light cut and the steps inhibited while an input is unsafe.
//  4. A halt by the rule Beyond or by the second switch is told before the steps are halted. One by the rule
//     AtContact is told when the contact has settled, with the time of its first edge.
//  5. A rule that has halted is Never from then on, a second switch that has is no longer watched: one halt a
//     rule.
//  6. The thread uses cutoff_ only while cutting_ is set.
//
// It is larger than other classes: its thread may neither lock nor wait, so that what it knows of the
// contacts and of the encoder, and what it hands over, are in one place.
#pragma once

#include <poll.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "hw/event_descriptor.hpp"
#include "hw/gpio/debounce.hpp"
#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/encoder_edges.hpp"
#include "hw/gpio/light_cutoff.hpp"
#include "hw/gpio/safety_contact.hpp"
#include "hw/gpio/step_engine.hpp"

namespace contourd {

enum class AxisInput : std::uint8_t { LimitSwitch, SecondSwitch, EmergencyStop, Lid };
inline constexpr std::size_t kAxisInputs = 4;

// A switch has come to rest, or a safety input's state has changed.
struct InputChange {
  AxisInput which = AxisInput::LimitSwitch;
  bool active = false;
  bool halted = false;                                           // the steps were halted for it
  TimePoint at{};                                                // the first edge to this level
  SafetyState from = SafetyState::Safe, to = SafetyState::Safe;  // of a safety input
  bool readable = true;                                          // the same
};

// When the limit switch halts the steps.
enum class LimitRule : std::uint8_t {
  Never,
  AtContact,  // at its first edge: homing
  Beyond,     // when it has settled and the motor stands where the switch should be open
};

class AxisInputs {
 public:
  struct Contact {
    InputLine* line = nullptr;  // not owned; null: there is none
    Duration debounce{};
  };
  struct Lines {
    std::array<Contact, kAxisInputs> contacts;  // by AxisInput
    InputLine *encoder_a = nullptr, *encoder_b = nullptr, *encoder_index = nullptr;
  };

  // Reads every level. The engine and the lines must outlive this. Throws std::system_error (an eventfd).
  AxisInputs(StepEngine& engine, const Lines& lines, StepEngine::Now now = monotonic_now);

  // The owner's.

  // From now on, and only while it is so: the rule holds once. `limit` is the last position at which a closed
  // switch is in order, for the rule Beyond: below it or, with `from_above`, above it.
  void set_limit_rule(LimitRule rule, std::int64_t limit = 0, bool from_above = false) noexcept;
  // Whether the second switch, once settled, halts the steps.
  void watch_second_switch(bool watched) noexcept;
  // What is cut from now on; null: nothing. The one before is no longer used once this has returned.
  void set_light_cutoff(LightCutoff* cutoff) noexcept;
  // Lets steps be made and the light go on again, as far as no input says otherwise by now.
  void let_go() noexcept;
  // A switch: closed. A safety input: not safe.
  [[nodiscard]] bool active(AxisInput which) const noexcept { return active_[index(which)]; }
  // A safety input has moved, and it is not known yet whether that lasts.
  [[nodiscard]] bool debouncing(AxisInput which) const noexcept {
    return states_[index(which)] == SafetyState::Debouncing;
  }
  [[nodiscard]] bool readable(AxisInput which) const noexcept { return !unreadable_[index(which)]; }
  [[nodiscard]] std::uint64_t edges(AxisInput which) const noexcept { return edges_[index(which)]; }
  [[nodiscard]] std::optional<InputChange> take_change() noexcept;
  // Readable when there are changes to take.
  [[nodiscard]] EventDescriptor& changes() noexcept { return changed_; }
  // Changes came faster than they were taken, a switch cannot be read, or a line's chip has gone: what is
  // said of the inputs cannot be relied on any more. The steps are inhibited and the light is cut.
  [[nodiscard]] bool lost() const noexcept { return lost_; }
  // Up while A leads B.
  [[nodiscard]] std::int64_t encoder_count() const noexcept { return count_; }
  [[nodiscard]] std::uint64_t illegal_encoder_edges() const noexcept { return illegal_; }
  // Of its lines.
  [[nodiscard]] std::uint64_t encoder_edges(EncoderLine which) const noexcept {
    return encoder_edges_[static_cast<std::size_t>(which)];
  }
  // How often the encoder's index was passed, and the count at which it was last, or at a later pass.
  struct IndexPulse {
    std::uint64_t number = 0;
    std::int64_t count = 0;
  };
  [[nodiscard]] IndexPulse index_pulse() const noexcept {
    const std::uint64_t number = index_pulses_;
    return {number, index_count_};
  }

  // The thread's.

  // Readable when the rules have changed.
  [[nodiscard]] EventDescriptor& work() noexcept { return work_; }
  // Takes all edges there are and does what follows from them. Returns when to call again, edges or not.
  std::optional<TimePoint> serve() noexcept;
  // What is to be waited for: the lines' edges, and work().
  static constexpr std::size_t kDescriptors = kAxisInputs + 4;
  [[nodiscard]] std::array<pollfd, kDescriptors> descriptors() const noexcept;
  // A descriptor has failed: its chip has gone.
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
  [[nodiscard]] bool unsafe() const noexcept;
  void cut_light() noexcept;
  void release_light() noexcept;
  void cut_again(TimePoint now) noexcept;
  [[nodiscard]] std::optional<TimePoint> next_due() const noexcept;
  void apply_rules() noexcept;
  void tell(const InputChange& change) noexcept;
  [[nodiscard]] bool out_of_place(std::int64_t position) const noexcept;
  [[nodiscard]] bool watching() const noexcept;

  StepEngine& engine_;
  Lines lines_;
  StepEngine::Now now_;
  EventDescriptor work_, changed_;

  std::atomic<LimitRule> limit_rule_{LimitRule::Never};
  std::atomic<std::int64_t> limit_{0};
  std::atomic<bool> from_above_{false}, second_watched_{false}, lost_{false};
  std::array<std::atomic<bool>, kAxisInputs> active_{}, unreadable_{};
  std::array<std::atomic<SafetyState>, kAxisInputs> states_{};  // those of the safety inputs
  std::array<std::atomic<std::uint64_t>, kAxisInputs> edges_{};
  std::array<std::atomic<std::uint64_t>, kEncoderLines> encoder_edges_{};
  std::atomic<LightCutoff*> cutoff_{nullptr};
  std::atomic<bool> cutting_{false};  // the thread uses it
  std::atomic<std::int64_t> count_{0};
  std::atomic<std::uint64_t> illegal_{0}, index_pulses_{0};
  std::atomic<std::int64_t> index_count_{0};

  // A spike on a safety input makes three changes. Mains hum makes 50 spikes a second: there is room for more
  // than a second of it.
  static constexpr std::uint32_t kChanges = 256;
  std::array<InputChange, kChanges> ring_{};
  std::atomic<std::uint32_t> told_{0}, taken_{0};

  // The thread's.
  std::array<Debounce, kAxisInputs> switches_;
  std::array<SafetyContact, kAxisInputs> safety_;
  std::array<bool, kAxisInputs> halted_{};  // in this bout of edges
  std::optional<TimePoint> cut_again_at_;
  EncoderEdges encoder_;
  TimePoint levels_read_{};
};

}  // namespace contourd
