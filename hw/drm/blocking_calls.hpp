// A thread for the kernel's calls that block: asking a display what it is takes 300 ms, setting a mode some
// refreshes, and a driver that hangs is waited for by the kernel for 10 s and more. Nothing of that may hold
// up the event loop, on which the light's end depends. Calls run one after the other; what they return is
// handed back on the loop's thread, in the same order.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "hw/descriptor_watcher.hpp"
#include "hw/event_descriptor.hpp"

namespace contourd {

class BlockingCalls {
 public:
  // The watcher must outlive it. Throws std::system_error.
  explicit BlockingCalls(DescriptorWatcher& watcher);
  // Waits for the call under way; those behind it are dropped, and no result is handed back any more.
  ~BlockingCalls();
  BlockingCalls(const BlockingCalls&) = delete;
  BlockingCalls& operator=(const BlockingCalls&) = delete;

  // Calls `call` on the thread, then `done` with its result on the loop's. `call` must not throw.
  template <typename Call, typename Done>
  void run(Call call, Done done) {
    enqueue([this, call = std::move(call), done = std::move(done)]() mutable {
      auto result = std::make_shared<decltype(call())>(call());
      post([result, done = std::move(done)]() mutable { done(std::move(*result)); });
    });
  }

 private:
  void enqueue(std::function<void()> call);
  void post(std::function<void()> result);
  void work(const std::stop_token& stop);
  void deliver();

  EventDescriptor event_;
  std::mutex mutex_;
  std::condition_variable_any ready_;
  std::deque<std::function<void()>> calls_;
  std::vector<std::function<void()>> results_;
  std::unique_ptr<DescriptorWatcher::Watch> watch_;
  std::jthread thread_;  // last: joined before what it uses goes
};

}  // namespace contourd
