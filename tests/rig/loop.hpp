// An event loop in virtual time. Calls that become due while the loop is held up run when it continues, in
// the kernel's order or another, while the world goes on. Not thread-safe.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <utility>

#include "hw/virtual_clock.hpp"

namespace contourd::rig {

class Loop final : public Clock {
 public:
  // The world must outlive the loop.
  explicit Loop(VirtualClock& world) : world_(world) {}

  [[nodiscard]] TimePoint now() const override { return world_.now(); }
  // Masks are computed in no time, so that a print is the same each time.
  [[nodiscard]] bool skips_waiting() const override { return true; }
  [[nodiscard]] std::unique_ptr<Timer> call_at(TimePoint when, std::function<void()> call) override {
    auto pending = std::make_shared<Pending>(Pending{std::move(call), true, {}});
    pending->timer = world_.call_at(when, [this, weak = std::weak_ptr(pending)] {
      if (const auto due = weak.lock()) take(due);
    });
    return std::make_unique<Handle>(std::move(pending));
  }

  // Queues a call for a device that has become readable.
  void post(std::function<void()> call) {
    take(std::make_shared<Pending>(Pending{std::move(call), false, {}}));
  }

  // Runs no calls for that time.
  void hold_up(Duration time) {
    busy_until_ = std::max(busy_until_, world_.now() + time);
    release_ = world_.call_at(busy_until_, [this] { drain(); });
  }
  // Holds the loop up in the middle of a call: the world goes on, by `turn`, before this returns.
  void hold_up_here(Duration time, const std::function<void()>& turn) {
    if (inside_) return;
    inside_ = true;
    bool over = false;
    const auto timer = world_.call_after(time, [&over] { over = true; });
    while (!over)
      turn();
    inside_ = false;
    was_inside_until_ = world_.now();
    release_ = world_.call_at(std::max(busy_until_, world_.now()), [this] { drain(); });
  }
  // Returns the last time at which the loop was or will be held up.
  [[nodiscard]] TimePoint held_up_until() const { return std::max(busy_until_, was_inside_until_); }
  [[nodiscard]] bool held_up() const { return inside_ || world_.now() < busy_until_; }

  // Order of calls that are due at the same time.
  enum class Order { AsItCame, TimersFirst, DevicesFirst } order = Order::AsItCame;

 private:
  struct Pending {
    std::function<void()> call;  // empty if it was cancelled
    bool is_timer;
    std::unique_ptr<Timer> timer;
  };
  class Handle final : public Timer {
   public:
    explicit Handle(std::shared_ptr<Pending> pending) : pending_(std::move(pending)) {}
    ~Handle() override {
      pending_->call = nullptr;
      pending_->timer.reset();
    }

   private:
    std::shared_ptr<Pending> pending_;
  };

  void take(const std::shared_ptr<Pending>& due) {
    if (held_up() || draining_ || !waiting_.empty()) {
      waiting_.push_back(due);
      // Runs after the calls that the loop is about to make, if any.
      if (!held_up() && !draining_) release_ = world_.call_after(Duration{0}, [this] { drain(); });
      return;
    }
    make(due);
  }
  static void make(const std::shared_ptr<Pending>& due) {
    // The call may cancel itself.
    if (const auto call = std::exchange(due->call, nullptr)) call();
  }
  void drain() {
    if (held_up() || draining_) return;
    if (order != Order::AsItCame) {
      const bool timers = order == Order::TimersFirst;
      std::ranges::stable_partition(waiting_,
                                    [timers](const auto& pending) { return pending->is_timer == timers; });
    }
    draining_ = true;
    while (!waiting_.empty() && !held_up()) {
      const auto due = waiting_.front();
      waiting_.pop_front();
      make(due);
    }
    draining_ = false;
  }

  VirtualClock& world_;
  TimePoint busy_until_{}, was_inside_until_{};
  bool inside_ = false, draining_ = false;
  std::deque<std::shared_ptr<Pending>> waiting_;
  std::unique_ptr<Timer> release_;
};

}  // namespace contourd::rig
