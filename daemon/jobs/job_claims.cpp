#include "daemon/jobs/job_claims.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "daemon/jobs/acceptances.hpp"
#include "daemon/spool/upload_state.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Returns why no job can begin because of the spool's disk; empty if one can. Throws std::system_error.
std::string trouble_of_disk(const Spool& spool, std::uintmax_t needed) {
  if (std::string trouble = spool.trouble(); !trouble.empty()) return trouble;
  const std::uintmax_t free = spool.free_bytes();
  if (free >= needed) return "";
  return fmt::format("the spool's disk has {} MB free, {} MB are needed", free / 1'000'000,
                     needed / 1'000'000);
}

// Throws std::system_error.
JobLook try_to_look(const Spool& spool, const std::string& file, const PrinterConfig& config) {
  JobLook look{.disk_trouble = trouble_of_disk(spool, config.min_free_disk_bytes)};
  if (!look.disk_trouble.empty()) return look;
  look.is_there = spool.is_waiting(file);
  const JobFiles files = spool.files_of(Spool::Folder::Incoming, file);
  look.is_unfinished = is_unfinished(files);
  look.content = content_mark(files);
  try {
    look.settings = read_settings(files, config);
  } catch (const ProfileTrouble& trouble) {
    look.profile_trouble = trouble;
  } catch (const JobRefused&) {
    // The reading of the job reports the reason.
  }
  return look;
}

}  // namespace

JobLook look_at(const Spool& spool, const std::string& file, const PrinterConfig& config) {
  try {
    return try_to_look(spool, file, config);
  } catch (const std::system_error& error) {
    return {.disk_trouble = fmt::format("the spool cannot be used: {}", printable(error.what()))};
  }
}

Claim claim_now(Spool& spool, const std::string& file) {
  try {
    return {spool.begin(file)};
  } catch (const std::system_error& error) {
    return {std::nullopt, error.code(), error.what(), spool.is_waiting(file)};
  }
}

void SpoolClaims::look(const std::string& file, std::function<void(const JobLook&)> done) {
  spool_.run([this, file] { return look_at(spool_, file, config_); }, std::move(done));
}

void SpoolClaims::claim(const std::string& file, std::function<void(const Claim&)> done) {
  spool_.moves_away(file);
  spool_.run([this, file] { return claim_now(spool_, file); }, std::move(done));
}

}  // namespace contourd
