// How a job is printed: by its ticket, and by the profile of the resin that this names, or else the printer's
// file. The printer's file is read when contourd starts; these are read when the job is claimed, and hold to
// its end. Thread-safe (no shared state).
#pragma once

#include <string>

#include "daemon/config/job_ticket.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/prepare/plate_arrangement.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

struct JobSettings {
  JobTicket ticket;
  ResinProfile resin;                           // with what the ticket sets in its place
  OverriddenSettings overridden{};              // which that is
  SupportPolicy supports = SupportPolicy::Off;  // the ticket's, or else the printer's
  bool operator==(const JobSettings&) const = default;
};

// The resin's profile cannot be used. what() is a reason to refuse the job by, which only a ticket deserves
// that names a profile which there is none of; a profile that is broken, or the printer's own that is
// missing, is nobody's fault who queued a job.
class ProfileTrouble : public JobRefused {
 public:
  enum class Fault { Ticket, Profile };
  ProfileTrouble(Fault fault, const std::string& reason, std::string sentence)
      : JobRefused(reason), fault_(fault), sentence_(std::move(sentence)) {}

  [[nodiscard]] Fault fault() const { return fault_; }
  // The same in one line.
  [[nodiscard]] const std::string& sentence() const { return sentence_; }

 private:
  Fault fault_;
  std::string sentence_;
};

// Throws JobRefused with what is wrong with the ticket, ProfileTrouble among it.
[[nodiscard]] JobSettings read_settings(const JobFiles& files, const PrinterConfig& printer);
// The same of a ticket at hand; `file` is its name in messages. Throws ConfigError with what the profile does
// not let it set, and ProfileTrouble.
[[nodiscard]] JobSettings settings_by(JobTicket ticket, const std::string& file,
                                      const PrinterConfig& printer);

}  // namespace contourd
