#include "daemon/spool/ignored_files.hpp"

#include <algorithm>
#include <array>

namespace contourd {
namespace {

// Maximum number of files that are reported by name before the rest is counted, and maximum number that
// settle in one turn of the event loop.
constexpr std::size_t kMaxNamed = 10, kMaxATurn = 50;

}  // namespace

void IgnoredFiles::saw(const std::string& file, WhyIgnored why) {
  if (const auto known = settled_.find(file); known != settled_.end() && known->second == why) return;
  forget(file);
  const TimePoint now = std::chrono::steady_clock::now();
  unsettled_.emplace(file, Unsettled{why, now});
  by_change_.emplace(now, file);
  if (!timer_) wait();
}

void IgnoredFiles::forget(const std::string& file) {
  settled_.erase(file);
  forget_unsettled(file);
}

void IgnoredFiles::forget_unsettled(const std::string& file) {
  const auto found = unsettled_.find(file);
  if (found == unsettled_.end()) return;
  by_change_.erase({found->second.changed, file});
  unsettled_.erase(found);
}

void IgnoredFiles::forget_all_but(const std::set<std::string>& files) {
  std::erase_if(settled_, [&files](const auto& each) { return !files.contains(each.first); });
  std::erase_if(unsettled_, [&files](const auto& each) { return !files.contains(each.first); });
  std::erase_if(by_change_, [&files](const auto& each) { return !files.contains(each.second); });
}

void IgnoredFiles::wait() {
  timer_ =
      loop_.at(by_change_.begin()->first + settled_after_, "the spool's timer", [this] { settle_some(); });
}

void IgnoredFiles::settle_some() {
  timer_.reset();
  const TimePoint settled = std::chrono::steady_clock::now() - settled_after_;
  for (std::size_t i = 0; i < kMaxATurn && !by_change_.empty() && by_change_.begin()->first <= settled; ++i) {
    const std::string file = by_change_.begin()->second;
    const WhyIgnored why = unsettled_.at(file).why;
    forget_unsettled(file);
    settle(file, why);
  }
  if (!by_change_.empty()) return wait();
  if (unnamed_ > 0) observer_.more_ignored(unnamed_);
  named_ = unnamed_ = 0;
}

void IgnoredFiles::settle(const std::string& file, WhyIgnored why) {
  settled_.emplace(file, why);
  if (named_ == kMaxNamed) {
    ++unnamed_;
    return;
  }
  ++named_;
  observer_.ignored(file, why);
}

}  // namespace contourd
