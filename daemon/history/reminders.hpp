// What of the machine is due to be replaced, as its owner wants to be reminded of it, by what the history
// last said of its use. Never a reason not to print. Event loop's thread only.
#pragma once

#include <string>
#include <vector>

#include "daemon/config/wear_part.hpp"

namespace contourd {

// A sentence; empty while the part is not due.
[[nodiscard]] std::string reminder_of(const WearPartUse& use, const WearLimits& limits);

class Reminders {
 public:
  // Must outlive the reminders.
  explicit Reminders(const ReminderConfig& config) : config_(config) {}

  // Whether there is anything to remind of, ever.
  [[nodiscard]] bool wanted() const;
  [[nodiscard]] const WearLimits& limits(WearPart part) const;

  // Of all parts, as the history has it.
  void update(const std::vector<WearPartUse>& uses);
  // A sentence for each part that is due.
  [[nodiscard]] const std::vector<std::string>& due() const { return due_; }

 private:
  const ReminderConfig& config_;
  std::vector<std::string> due_;
};

}  // namespace contourd
