// Reminders to replace parts of the machine, by the limits that the user has configured and the usage that
// the history reported last. Reminders never prevent a print. Event loop's thread only.
#pragma once

#include <string>
#include <vector>

#include "daemon/config/wear_part.hpp"

namespace contourd {

// Returns a sentence if the part is due, else an empty text.
[[nodiscard]] std::string reminder_of(const WearPartUse& use, const WearLimits& limits);

class Reminders {
 public:
  // `config` must outlive the object.
  explicit Reminders(const ReminderConfig& config) : config_(config) {}

  // True if a limit is configured.
  [[nodiscard]] bool wanted() const;
  [[nodiscard]] const WearLimits& limits(WearPart part) const;

  // Takes the usage of all parts from the history.
  void update(const std::vector<WearPartUse>& uses);
  // One sentence for each part that is due.
  [[nodiscard]] const std::vector<std::string>& due() const { return due_; }

 private:
  const ReminderConfig& config_;
  std::vector<std::string> due_;
};

}  // namespace contourd
