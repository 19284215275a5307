// A thread for kernel calls that block: reading a display's EDID takes 300 ms, setting a mode takes a few
// refreshes, and for a hanging driver the kernel waits 10 s or more. None of this may delay the event loop,
// which turns the light off. Calls run one after another; their results are delivered on the loop's thread,
// in the same order.
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
  // The watcher must outlive this object. Throws std::system_error.
  explicit BlockingCalls(DescriptorWatcher& watcher);
  // Waits for the running call. Drops the queued ones and delivers no more results.
  ~BlockingCalls();
  BlockingCalls(const BlockingCalls&) = delete;
  BlockingCalls& operator=(const BlockingCalls&) = delete;

  // Runs `call` on the thread, then `done` with the result on the loop's thread. `call` must not throw.
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
  std::jthread thread_;  // last member: joined before the members that it uses are destroyed
};

}  // namespace contourd
