// A thread for work that would block the event loop for too long, such as reading or analysing models. Tasks
// run one after another; their results are delivered on the loop's thread.
#pragma once

#include <pthread.h>
#include <sys/resource.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "daemon/system/event_loop.hpp"

namespace contourd {

class Worker {
 public:
  // Starts a thread named `name` (at most 15 characters) with this niceness (setpriority(2), at most 19). In
  // a service, the event loop's niceness is lower (see contourd.service).
  Worker(EventLoop& loop, const char* name, int niceness = 0)
      : mailbox_(loop), thread_([this, name, niceness](const std::stop_token& stop) {
          // Linux sets the niceness of the calling thread only. The work is done even if one of these calls
          // fails.
          (void)::pthread_setname_np(::pthread_self(), name);
          (void)::setpriority(PRIO_PROCESS, 0, niceness);
          work(stop);
        }) {}

  // Calls `task` on the worker's thread, then `done` with its result on the loop's. `task` must not throw.
  template <typename Task, typename Done>
  void run(Task task, Done done) {
    enqueue([this, task = std::move(task), done = std::move(done)]() mutable {
      auto result = std::make_shared<decltype(task())>(task());
      mailbox_.post([result, done = std::move(done)]() mutable { done(std::move(*result)); });
    });
  }

 private:
  void enqueue(std::function<void()> call) {
    {
      const std::lock_guard lock(mutex_);
      tasks_.push_back(std::move(call));
    }
    ready_.notify_one();
  }

  void work(const std::stop_token& stop) {
    while (true) {
      std::unique_lock lock(mutex_);
      if (!ready_.wait(lock, stop, [this] { return !tasks_.empty(); })) return;
      const std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      task();
    }
  }

  Mailbox mailbox_;
  std::mutex mutex_;
  std::condition_variable_any ready_;
  std::deque<std::function<void()>> tasks_;
  std::jthread thread_;  // last: joined before what it uses goes
};

}  // namespace contourd
