// The disk's part of the claim of the next job: a look at its files, settings and disk, and the move of its
// files to printing/. Event loop's thread only; the disk is used on the spool's thread.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <system_error>

#include "daemon/config/printer_config.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

// The next job and the spool's disk, as they are before a claim. A value.
struct JobLook {
  std::string disk_trouble{};  // why no job can begin now; else empty
  bool is_there = false;       // false if incoming/ does not have the job any more
  bool is_unfinished = false;  // a process has one of its files open for writing, or a plate lacks a file
  std::string content{};       // see content_mark()
  std::optional<JobSettings> settings{};            // nullopt if they cannot be used
  std::optional<ProfileTrouble> profile_trouble{};  // why they cannot, if that is not the ticket's text alone
};

// Looks at incoming/`file`. Any thread may call it; blocks.
[[nodiscard]] JobLook look_at(const Spool& spool, const std::string& file, const PrinterConfig& config);

// The result of a claim: the job's files in printing/, or the error of the disk.
struct Claim {
  std::optional<JobFiles> files;
  std::error_code code{};
  std::string trouble{};  // a sentence
  bool is_there = true;   // false if incoming/ does not have the job any more
};

// Moves incoming/`file` to printing/: see Spool::begin(). Any thread may call it; blocks.
[[nodiscard]] Claim claim_now(Spool& spool, const std::string& file);

// Looks at jobs and claims them without blocking: each `done` is called from the loop.
class JobClaims {
 public:
  virtual ~JobClaims() = default;

  virtual void look(const std::string& file, std::function<void(const JobLook&)> done) = 0;
  virtual void claim(const std::string& file, std::function<void(const Claim&)> done) = 0;
};

class SpoolClaims final : public JobClaims {
 public:
  // Both must outlive the claims.
  SpoolClaims(Spool& spool, const PrinterConfig& config) : spool_(spool), config_(config) {}

  void look(const std::string& file, std::function<void(const JobLook&)> done) override;
  void claim(const std::string& file, std::function<void(const Claim&)> done) override;

 private:
  Spool& spool_;
  const PrinterConfig& config_;
};

}  // namespace contourd
