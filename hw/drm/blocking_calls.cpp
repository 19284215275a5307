#include "hw/drm/blocking_calls.hpp"

namespace contourd {

BlockingCalls::BlockingCalls(DescriptorWatcher& watcher)
    : watch_(watcher.when_readable(event_.descriptor(), [this] { deliver(); })),
      thread_([this](const std::stop_token& stop) { work(stop); }) {}

BlockingCalls::~BlockingCalls() = default;

void BlockingCalls::enqueue(std::function<void()> call) {
  {
    const std::lock_guard lock(mutex_);
    calls_.push_back(std::move(call));
  }
  ready_.notify_one();
}

void BlockingCalls::work(const std::stop_token& stop) {
  while (true) {
    std::unique_lock lock(mutex_);
    if (!ready_.wait(lock, stop, [this] { return !calls_.empty(); }) || stop.stop_requested()) return;
    const std::function<void()> call = std::move(calls_.front());
    calls_.pop_front();
    lock.unlock();
    call();
  }
}

void BlockingCalls::post(std::function<void()> result) {
  {
    const std::lock_guard lock(mutex_);
    results_.push_back(std::move(result));
  }
  event_.signal();
}

void BlockingCalls::deliver() {
  event_.clear();
  std::vector<std::function<void()>> results;
  {
    const std::lock_guard lock(mutex_);
    results.swap(results_);
  }
  for (const auto& result : results)
    result();
}

}  // namespace contourd
