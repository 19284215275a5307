#include "daemon/app/sleep_inhibitor.hpp"

#include <utility>

namespace contourd {

SleepInhibitor::SleepInhibitor(SleepAuthority& authority, Clock& clock, SleepingPrint& print)
    : authority_(authority), clock_(clock), print_(print) {
  authority_.on_sleep([this](bool asleep) {
    if (asleep) return sleep();
    look_.reset();
    if (wanted_) take();
  });
}

void SleepInhibitor::hold(bool wanted) {
  if (std::exchange(wanted_, wanted) == wanted) return;
  if (wanted) return take();
  block_ = FileDescriptor();
  delay_ = FileDescriptor();
}

void SleepInhibitor::take() {
  for (const auto& [lock, kept] :
       {std::pair{SleepAuthority::Lock::Block, &block_}, std::pair{SleepAuthority::Lock::Delay, &delay_}}) {
    if (kept->valid()) continue;
    ++pending_;
    authority_.take(lock, [this, kept = kept](FileDescriptor descriptor, const std::string& refusal) {
      taken(*kept, std::move(descriptor), refusal);
    });
  }
}

void SleepInhibitor::taken(FileDescriptor& kept, FileDescriptor lock, const std::string& refusal) {
  --pending_;
  if (wanted_) kept = std::move(lock);
  const bool unguarded = wanted_ && pending_ == 0 && !block_.valid() && !delay_.valid();
  if (unguarded && !std::exchange(reported_, true)) print_.unguarded(refusal);
}

void SleepInhibitor::sleep() {
  if (!wanted_) return;
  print_.interrupt();
  let_sleep_when_dark();
}

void SleepInhibitor::let_sleep_when_dark() {
  if (!print_.dark()) {
    look_ = clock_.call_after(kLook, [this] { let_sleep_when_dark(); });
    return;
  }
  delay_ = FileDescriptor();
}

}  // namespace contourd
