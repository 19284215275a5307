// Makes moves as step pulses, one after another: the work of the step thread without its waiting. The event
// loop starts and stops moves; the step thread, or a test with its own clock, runs them; any thread may halt
// them. The functions for the step thread neither allocate, lock, log nor throw. The lines and this object
// must outlive the thread.
//
// A step that is late by more than a quarter of the following interval shifts the rest of the schedule by its
// lateness. So intervals are never shorter than three quarters of the planned ones, and late steps are never
// made up for in a burst.
//
// A step that is so late that the motor has come to rest is not made as planned: the remaining steps ramp up
// again from rest, or are dropped if the move is to stop. The limit is the smaller of two times. One is 16
// intervals at the step's speed: with the usual 16 microsteps per full step, a rotor follows its field within
// two full steps. The other is 5 ms, a quarter of the oscillation period of a slow rotor (50 Hz) about a
// field at rest. A motor that was above its pull-in speed has stalled then and may have lost steps. A slower
// motor has stopped dead and lost none.
//
// A rise, whose speeds are below the motor's pull-in speed, is never ramped up again: a late step shifts the
// rest of it.
//
// Invariants of the state that phase_ passes between the threads:
//  1. Only the event loop sets phase_ from Idle to Handed, after writing move_ and the schedule's start.
//  2. Only the step thread sets it from Handed to Running, and reads move_ afterwards.
//  3. Only the step thread sets it from Running to Idle, after writing end_. Afterwards it touches neither
//     move_ nor end_. It signals ended() only then, so the signal may come during the next move.
//  4. The event loop reads end_ and writes move_ only while phase_ is Idle. After start(), end_ is the next
//     move's.
//  5. Only forget_halt() resets halt_ and brake_, and only start() resets stop_, both while phase_ is Idle;
//     neither resets inhibited_. A rule that halts moves is set between forget_halt() and start(), so no step
//     is made without it, however little the event loop runs.
//  6. The step thread changes position_ and history_, with each step that the line has accepted, while
//     stepping_ is set. set_position() changes position_ and from_ while phase_ is Idle.
//  7. While phase_ is Idle, the position is from_ plus the steps that the history has gained since start().
//
// Cost measured with callgrind (g++ 12 -O3, amd64, as in step_planner.hpp; without kernel calls): 229
// instructions per step on a trapezoid, 270 on an S-curve, planning included.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "core/contract/expects.hpp"
#include "hw/event_descriptor.hpp"
#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/step_history.hpp"
#include "hw/gpio/step_planner.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

[[nodiscard]] TimePoint monotonic_now() noexcept;

struct StepTiming {
  Duration pulse_width{2'000};      // minimum of a pulse, and of the pause between pulses
  Duration direction_setup{5'000};  // minimum from a change of direction to a pulse
};

struct StepMove {
  std::int64_t steps = 0;  // positive: the direction line is active
  MotionLimits limits;     // in steps
  // The highest speed, in steps/s, at which the motor can stop dead and start at once without losing steps.
  double pull_in = std::numeric_limits<double>::infinity();
  bool ends_stalled = false;  // the move ends if the motor stalls; otherwise it continues
  // The curve of a rise, in steps from the start; null for a move of its own within the limits.
  std::shared_ptr<const RiseCurve> rise{};
};

enum class StepEnd {
  Completed,
  Stopped,      // slowed down to rest before the end
  Halted,       // no further step was made
  Stalled,      // the motor stalled and the move had ends_stalled
  LineRefused,  // the kernel refused to set a line
};

// The stalls: the motor came to rest from a speed at which it may have lost steps.
struct Stalls {
  std::uint64_t count = 0;
  // The lateness and speed of the last stall.
  Duration late{};
  double speed = 0;  // steps/s
};

class StepEngine {
 public:
  using Now = TimePoint (*)() noexcept;

  // The limits of lateness, in intervals at the step's speed and as a time, beyond which the motor has come
  // to rest: see above.
  static constexpr double kIntervals = 16;
  static constexpr Duration kSwing{std::chrono::milliseconds{5}};

  // Throws std::system_error (an eventfd).
  StepEngine(OutputLine& step, OutputLine& direction, const StepTiming& timing, Now now = monotonic_now);

  // Functions for the event loop's thread.

  // Resets earlier halts and brakes: those from now on apply to the next move. REQUIRES: !moving().
  void forget_halt() noexcept {
    expects(!moving(), "no move is under way");
    halt_ = brake_ = false;
  }
  // Starts a move. REQUIRES: !moving(); a rise goes upwards, no faster than pull_in.
  void start(const StepMove& move) noexcept;
  // Slows the move down to rest.
  void stop() noexcept;
  [[nodiscard]] bool moving() const noexcept { return phase_.load(std::memory_order_acquire) != Phase::Idle; }
  // Returns how the last move ended. REQUIRES: !moving().
  [[nodiscard]] StepEnd last_end() const noexcept {
    expects(!moving(), "no move is under way");
    return end_;
  }
  // Returns a descriptor that is readable when a move has ended.
  [[nodiscard]] EventDescriptor& ended() noexcept { return ended_; }
  // Sets the position without moving. REQUIRES: !moving().
  void set_position(std::int64_t position) noexcept;
  // Returns where the motor was, or by plan will be, at a time within the present or the last move. For an
  // earlier time, returns where that move began.
  [[nodiscard]] std::int64_t position_at(TimePoint time) const noexcept;
  // Both return totals of all moves so far.
  [[nodiscard]] LateSteps late_steps() const noexcept { return {late_, Duration{worst_ns_}}; }
  [[nodiscard]] Stalls stalls() const noexcept;

  // Functions for any thread.

  // Halts the present move, if any: no further step is made after this has returned. Waits for a step that is
  // just being made; forever, if the waiting keeps the step thread from its processor.
  void halt() noexcept;
  // Halts the present move without waiting: a step that is just being made is completed.
  void halt_soon() noexcept { halt_ = true; }
  // Ends the present move without waiting and without losing steps: a motor at its pull-in speed or below
  // makes no further step, apart from one that is just being made; a faster one slows down to that speed
  // first.
  void brake_soon() noexcept { brake_ = true; }
  // Halts like halt_soon(), and no move makes a step until enable().
  void inhibit() noexcept;
  void enable() noexcept { inhibited_ = false; }
  [[nodiscard]] bool inhibited() const noexcept { return inhibited_; }
  // Inhibits every engine of the process for good; for a process that is about to end.
  static void inhibit_all() noexcept { all_inhibited_ = true; }
  // Returns the steps really made, up minus down.
  [[nodiscard]] std::int64_t position() const noexcept { return position_.load(std::memory_order_acquire); }

  // Functions for the step thread.

  // Returns a descriptor that is readable when there is a move to begin.
  [[nodiscard]] EventDescriptor& work() noexcept { return work_; }
  // Begins a move that was started. False if there is none or it has ended already.
  bool begin() noexcept;
  // Returns when to call act() while running(). If interrupted(), act() is to be called at once; calling it
  // early is harmless.
  [[nodiscard]] TimePoint due() const noexcept { return due_; }
  [[nodiscard]] bool interrupted() const noexcept {
    return halt_.load(std::memory_order_relaxed) || inhibited_.load(std::memory_order_relaxed) ||
           all_inhibited_.load(std::memory_order_relaxed) ||
           ((stop_.load(std::memory_order_relaxed) || brake_.load(std::memory_order_relaxed)) && !stopped_);
  }
  void act() noexcept;
  [[nodiscard]] bool running() const noexcept {
    return phase_.load(std::memory_order_relaxed) == Phase::Running;
  }

 private:
  enum class Phase { Idle, Handed, Running };

  // The present one of the ramps that make up a move.
  struct Ramp {
    Duration start{};       // the start of its schedule, with all shifts; 0 before it has begun
    std::int64_t made = 0;  // the steps of the move before this ramp
  };
  // A stop as the event loop requested it.
  struct Stop {
    std::int64_t made = 0;  // Ramp::made at that time
    Duration elapsed{};     // time since the ramp's start
  };

  [[nodiscard]] bool halted() const noexcept { return halt_ || inhibited_ || all_inhibited_; }
  [[nodiscard]] Ramp ramp() const noexcept;
  [[nodiscard]] StepPlanner plan_of(std::int64_t steps) const noexcept;
  [[nodiscard]] StepPlanner planned(const Ramp& ramp) const noexcept;
  void rise() noexcept;
  void fall() noexcept;
  bool make_step(TimePoint now) noexcept;
  void note_lateness(Duration late) noexcept {
    if (late.count() > worst_ns_) worst_ns_ = late.count();
  }
  void keep_time(Duration late) noexcept;
  [[nodiscard]] bool come_to_rest(Duration late) const noexcept;
  void start_again(TimePoint now, Duration late) noexcept;
  void slow_down(TimePoint now, Duration late) noexcept;
  void plan_rise(TimePoint now) noexcept;
  void finish(StepEnd end) noexcept;

  OutputLine& step_;
  OutputLine& direction_;
  StepTiming timing_;
  Now now_;
  EventDescriptor work_, ended_;

  std::atomic<Phase> phase_{Phase::Idle};
  std::atomic<bool> stop_{false}, brake_{false}, halt_{false}, inhibited_{false};
  inline static std::atomic<bool> all_inhibited_{false};
  std::atomic<bool> stepping_{false};  // from the check for a halt until the step has been made
  std::atomic<std::int64_t> position_{0};
  StepHistory history_;
  std::atomic<std::int64_t> start_ns_{0};  // Ramp::start; grows within a move
  std::atomic<std::int64_t> made_before_ramp_{0};
  std::atomic<std::uint64_t> late_{0}, stalls_{0};
  std::atomic<std::int64_t> worst_ns_{0}, stall_late_ns_{0};
  std::atomic<double> stall_speed_{0};

  // Passed by phase_: used by the event loop while Idle, otherwise by the step thread.
  StepMove move_;
  StepEnd end_ = StepEnd::Completed;
  // Members of the event loop, for the present move.
  std::optional<Stop> asked_to_stop_;
  std::int64_t from_ = 0, sign_ = 1;
  std::uint64_t made_before_ = 0;

  // Members of the step thread.
  StepPlanner plan_;     // the ramp's plan
  Duration planned_{};   // the time of the next step after the schedule's start
  Duration harmless_{};  // the lateness up to which the motor does not come to rest at any speed of the move
  TimePoint due_{};
  bool high_ = false, stopped_ = false;
  int last_direction_ = 0;  // 0 if not set yet
};

}  // namespace contourd
