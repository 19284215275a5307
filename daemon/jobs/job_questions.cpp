#include "daemon/jobs/job_questions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Returns the name quoted as one word of a shell, preceded by "--" if contourctl would take it for an option.
std::string shell_word(const std::string& name) {
  const std::string text = printable(name);
  const auto is_plain = [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '.' || letter == '_' || letter == '-';
  };
  const std::string before = text.starts_with('-') ? "-- " : "";
  if (std::ranges::all_of(text, is_plain)) return before + text;
  std::string word = "'";
  for (const char letter : text)
    word += letter == '\'' ? "'\\''" : std::string(1, letter);
  return before + word + "'";
}

}  // namespace

std::vector<std::string> JobQuestions::about(const AnalyzedJob& job) const {
  std::vector<std::string> asked = asked_findings(job.analysis, config_);
  std::erase_if(asked, [&](const std::string& finding) { return acceptances_.has(job.content, finding); });
  return asked;
}

bool JobQuestions::knows(const std::optional<AnalyzedJob>& job, const std::string& content,
                         const std::optional<JobSettings>& settings) const {
  if (!wanted() && !job) return true;
  return job && settings && job->settings == *settings && !content.empty() && job->content == content;
}

bool JobQuestions::withdraw_confirmation(const AnalyzedJob& job) {
  const std::string finding(kToBeConfirmed);
  if (!acceptances_.has(job.content, finding)) return false;
  acceptances_.remove(job.content, finding);
  return true;
}

void JobQuestions::ended() {
  if (!begun_.empty()) acceptances_.remove(std::exchange(begun_, ""));
}

std::string question_about(const std::string& file, const std::vector<std::string>& findings) {
  if (findings.empty()) return "";
  return fmt::format("{}; run \"contourctl accept {}\" to print it anyway", findings_text(findings),
                     shell_word(job_name_of(file)));
}

}  // namespace contourd
