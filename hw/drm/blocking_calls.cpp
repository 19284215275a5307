#include "hw/drm/blocking_calls.hpp"

#include <sys/eventfd.h>

#include <cerrno>
#include <system_error>

namespace contourd {
namespace {

FileDescriptor made_eventfd() {
  FileDescriptor fd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!fd.valid()) throw std::system_error(errno, std::generic_category(), "making an eventfd");
  return fd;
}

}  // namespace

BlockingCalls::BlockingCalls(DescriptorWatcher& watcher)
    : event_(made_eventfd()),
      watch_(watcher.when_readable(event_.get(), [this] { deliver(); })),
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
  // Can only fail when the counter is full, and then the loop is awake already.
  (void)::eventfd_write(event_.get(), 1);
}

void BlockingCalls::deliver() {
  eventfd_t posts = 0;
  (void)::eventfd_read(event_.get(), &posts);
  std::vector<std::function<void()>> results;
  {
    const std::lock_guard lock(mutex_);
    results.swap(results_);
  }
  for (const auto& result : results)
    result();
}

}  // namespace contourd
