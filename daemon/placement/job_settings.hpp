// Settings of a job: its ticket, and the profile of the resin named by the ticket or else by the printer's
// file. contourd reads the printer's file when it starts. It reads ticket and profile when it checks the job
// in the queue, and again when it claims the job; the settings read then apply until the job's end.
// contourctl reads them to draw and to forecast a job. Thread-safe (no shared state).
#pragma once

#include <string>

#include "daemon/config/job_ticket.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

// The settings that a job is printed with.
struct JobSettings {
  JobTicket ticket;
  ResinProfile resin;                           // with the ticket's overrides applied
  OverriddenSettings overridden{};              // overrides from the ticket
  SupportPolicy supports = SupportPolicy::Off;  // the ticket's, or else the printer's
  bool operator==(const JobSettings&) const = default;
};

// Thrown if the resin's profile cannot be used; what() is a reason to refuse the job. The ticket is at fault
// if it names a profile that does not exist. If the profile is broken, or the printer's own is missing, the
// person who queued the job is not to blame, and the job need not be refused.
class ProfileTrouble : public JobRefused {
 public:
  enum class Fault { Ticket, Profile };
  ProfileTrouble(Fault fault, const std::string& reason, std::string sentence)
      : JobRefused(reason), fault_(fault), sentence_(std::move(sentence)) {}

  [[nodiscard]] Fault fault() const { return fault_; }
  // Returns what is wrong with the profile, in one line.
  [[nodiscard]] const std::string& sentence() const { return sentence_; }

 private:
  Fault fault_;
  std::string sentence_;
};

// Reads the job's ticket and its resin's profile. Throws JobRefused if the ticket is wrong, and
// ProfileTrouble.
[[nodiscard]] JobSettings read_settings(const JobFiles& files, const PrinterConfig& printer);
// Applies a ticket to its resin's profile; `file` is the ticket's name in messages. Throws ConfigError if the
// ticket overrides settings beyond the profile's limits, and ProfileTrouble.
[[nodiscard]] JobSettings settings_by(JobTicket ticket, const std::string& file,
                                      const PrinterConfig& printer);

}  // namespace contourd
