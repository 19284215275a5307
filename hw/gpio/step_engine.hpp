// One move after the other as step pulses: what the stepping thread does, without the waiting. Told by one
// thread (the owner: the event loop), run by another (the stepping thread, or a test under its own time),
// halted by any. What runs neither allocates, locks, logs nor throws. Lines and this object must outlive the
// thread.
//
// A step that comes later than a quarter of the interval behind it shifts the rest of the schedule by its
// lateness: intervals are never shorter than three quarters of what was planned, and steps are never made up
// for in a bunch.
//
// One that comes so late that the motor has come to rest meanwhile is not made: the steps that are left ramp
// up again from rest, and none are left once the move is to stop. So late is later than 16 intervals at the
// speed of that step, at the usual 16 microsteps a full step, of which a rotor follows its field within two;
// or than 5 ms, a quarter of the swing of a slow rotor (50 Hz) about a field that stands still. A motor above
// its pull-in speed has stalled then: it may have lost steps. Slower ones have stopped dead and lost none.
//
// Invariants, of what phase_ hands from thread to thread:
//  1. Only the owner makes it Handed, from Idle, and has written move_ and the schedule's start before.
//  2. Only the thread makes it Running, from Handed; it reads move_ from then on.
//  3. Only the thread makes it Idle, from Running, and has written end_ before. It touches neither move_ nor
//     end_ from then on, though it has yet to signal ended(): that may come within the next move.
//  4. The owner reads end_ and writes move_ only while it is Idle. From start() on, end_ is the next move's.
//  5. halt_ is forgotten by forget_halt() alone, stop_ by start(), both while it is Idle; inhibited_ by
//  neither.
//     Who halts by a rule is told that rule in between: no step is made without it, however little the owner
//     runs.
//  6. position_ and history_ change by the thread, with each step that the line has taken, while stepping_ is
//     set; set_position() moves position_ while it is Idle, and from_ with it.
//  7. While it is Idle, the position is from_ and the steps that the history has gained since start().
//
// It is larger than other classes: all that the two threads share of a move is in one place, under these
// rules.
//
// Cost by callgrind (g++ 12 -O3, amd64, as in step_planner.hpp; without the kernel's calls): 229 instructions
// a step on a trapezoid, 270 on an S-curve, planning included.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
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
  Duration pulse_width{2'000};      // of the active level, and of the pause between pulses, at least
  Duration direction_setup{5'000};  // from the direction's change to a pulse, at least
};

struct StepMove {
  std::int64_t steps = 0;  // positive: the direction line active
  MotionLimits limits;     // in steps
  // Speed, in steps/s, from which the motor stops dead and to which it starts dead without losing steps.
  double pull_in = std::numeric_limits<double>::infinity();
  bool ends_stalled = false;  // or else it goes on when the motor has stalled
};

enum class StepEnd {
  Completed,
  Stopped,      // slowed down to rest before the end
  Halted,       // no further step from that instant
  Stalled,      // the motor has, and the move was to end then
  LineRefused,  // the kernel would not set a line
};

// Times that the motor came to rest at a speed at which it may have lost steps.
struct Stalls {
  std::uint64_t count = 0;
  // Of the last one.
  Duration late{};
  double speed = 0;  // steps/s
};

class StepEngine {
 public:
  using Now = TimePoint (*)() noexcept;

  // Later than one of these, by the intervals of its speed, a step finds the motor at rest: see above.
  static constexpr double kIntervals = 16;
  static constexpr Duration kSwing{std::chrono::milliseconds{5}};

  // Throws std::system_error (an eventfd).
  StepEngine(OutputLine& step, OutputLine& direction, const StepTiming& timing, Now now = monotonic_now);

  // The owner's.

  // Halts from now on are the next move's. REQUIRES: !moving().
  void forget_halt() noexcept {
    expects(!moving(), "no move is under way");
    halt_ = false;
  }
  // REQUIRES: !moving().
  void start(const StepMove& move) noexcept;
  // Slows the move down to rest.
  void stop() noexcept;
  [[nodiscard]] bool moving() const noexcept { return phase_.load(std::memory_order_acquire) != Phase::Idle; }
  // How the last move ended. REQUIRES: !moving().
  [[nodiscard]] StepEnd last_end() const noexcept {
    expects(!moving(), "no move is under way");
    return end_;
  }
  // Readable when a move has ended.
  [[nodiscard]] EventDescriptor& ended() noexcept { return ended_; }
  // REQUIRES: !moving().
  void set_position(std::int64_t position) noexcept;
  // Where the motor was or, as planned, will be at a time within the move under way or the last one; before
  // it, where that began.
  [[nodiscard]] std::int64_t position_at(TimePoint time) const noexcept;
  // Of all moves so far.
  [[nodiscard]] LateSteps late_steps() const noexcept;
  [[nodiscard]] Stalls stalls() const noexcept;

  // Any thread's.

  // Once it has returned no further step is made: of the move under way, if any. Waits for a step just being
  // made; for ever, where the waiting keeps the stepping thread from its processor.
  void halt() noexcept;
  // The same without waiting: a step just being made is still made.
  void halt_soon() noexcept { halt_ = true; }
  // Halts in the same way; no move makes a step until enable().
  void inhibit() noexcept;
  void enable() noexcept { inhibited_ = false; }
  [[nodiscard]] bool inhibited() const noexcept { return inhibited_; }
  // Inhibits every engine of the process, which is about to end, for good.
  static void inhibit_all() noexcept { all_inhibited_ = true; }
  // Steps really made, up less down.
  [[nodiscard]] std::int64_t position() const noexcept { return position_.load(std::memory_order_acquire); }

  // The stepping thread's.

  // Readable when there is a move to begin.
  [[nodiscard]] EventDescriptor& work() noexcept { return work_; }
  // Takes up a move that was started; false when there is none, or when it has ended already.
  bool begin() noexcept;
  // When act() is to be called, for as long as it is running(); earlier if interrupted(): being early does no
  // harm.
  [[nodiscard]] TimePoint due() const noexcept { return due_; }
  [[nodiscard]] bool interrupted() const noexcept {
    return halt_.load(std::memory_order_relaxed) || inhibited_.load(std::memory_order_relaxed) ||
           all_inhibited_.load(std::memory_order_relaxed) ||
           (stop_.load(std::memory_order_relaxed) && !stopped_);
  }
  void act() noexcept;
  [[nodiscard]] bool running() const noexcept {
    return phase_.load(std::memory_order_relaxed) == Phase::Running;
  }

 private:
  enum class Phase { Idle, Handed, Running };

  // Of the ramps that a move consists of, the one under way.
  struct Ramp {
    Duration start{};       // of its schedule, with all shifts; 0 before it has begun
    std::int64_t made = 0;  // steps of the move before it
  };
  // The owner's view of a stop.
  struct Stop {
    std::int64_t made = 0;  // the ramp's
    Duration elapsed{};     // from the ramp's start
  };

  [[nodiscard]] bool halted() const noexcept { return halt_ || inhibited_ || all_inhibited_; }
  [[nodiscard]] Ramp ramp() const noexcept;
  [[nodiscard]] StepPlanner planned(const Ramp& ramp) const noexcept;
  void rise() noexcept;
  void fall() noexcept;
  bool make_step(TimePoint now) noexcept;
  void note_lateness(Duration late) noexcept;
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
  std::atomic<bool> stop_{false}, halt_{false}, inhibited_{false};
  inline static std::atomic<bool> all_inhibited_{false};
  std::atomic<bool> stepping_{false};  // between looking for a halt and having made the step
  std::atomic<std::int64_t> position_{0};
  StepHistory history_;
  std::atomic<std::int64_t> start_ns_{0};  // the ramp's; grows within a move
  std::atomic<std::int64_t> made_before_ramp_{0};
  std::atomic<std::uint64_t> late_{0}, stalls_{0};
  std::atomic<std::int64_t> worst_ns_{0}, stall_late_ns_{0};
  std::atomic<double> stall_speed_{0};

  // Handed over by phase_: the owner's while Idle, else the thread's.
  StepMove move_;
  StepEnd end_ = StepEnd::Completed;
  // The owner's, of the move under way.
  std::optional<Stop> asked_to_stop_;
  std::int64_t from_ = 0, sign_ = 1;
  std::uint64_t made_before_ = 0;

  // The thread's.
  StepPlanner plan_;     // of the ramp
  Duration planned_{};   // the next step, after the schedule's start
  Duration harmless_{};  // the lateness up to which the motor turns on at any of the move's speeds
  TimePoint due_{};
  bool high_ = false, stopped_ = false;
  int last_direction_ = 0;  // 0: not set yet
};

}  // namespace contourd
