#include "daemon/spool/spool_folders.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "daemon/config/printer_places.hpp"
#include "daemon/formats/model_names.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// File names have at most 255 bytes; a job's name leaves room for a number and for suffixes like
// ".report.json".
constexpr std::size_t kLongestName = 200;

bool is_there(const fs::path& path) {
  std::error_code code;  // a name that is too long counts as absent
  return fs::exists(fs::symlink_status(path, code));
}

// Returns the first name that is free of NAME, NAME-2, NAME-3 ...
template <typename IsUsed>
std::string numbered(const std::string& name, const IsUsed& is_used) {
  std::string candidate = name;
  for (int number = 2; is_used(candidate); ++number)
    candidate = fmt::format("{}-{}", name, number);
  return candidate;
}

// Shortens the name without a cut inside a UTF-8 sequence, which has at most three continuation bytes.
std::string shortened_name(const std::string& stem) {
  std::string name = stem.substr(0, kLongestName);
  const auto continues = [&](std::size_t at) {
    return at < stem.size() && (static_cast<unsigned char>(stem[at]) & 0xC0U) == 0x80;
  };
  for (int i = 0; i < 3 && continues(name.size()); ++i)
    name.pop_back();
  return name;
}

// Returns all spellings of a lower-case extension, with each letter in either case.
std::vector<std::string> spellings_of(std::string_view extension) {
  std::vector<std::string> spellings{""};
  for (const char c : extension) {
    const bool is_letter = c >= 'a' && c <= 'z';
    for (std::size_t i = 0, shorter = spellings.size(); i < shorter; ++i) {
      if (is_letter) spellings.push_back(spellings[i] + static_cast<char>(c - 'a' + 'A'));
      spellings[i] += c;
    }
  }
  return spellings;
}

}  // namespace

std::string job_name_of(const std::string& file) {
  return is_model_name(file) ? model_stem(file) : file;
}

bool is_model_name(const std::string& file) {
  return !model_extension(file).empty() && !file.starts_with('.');
}

SpoolFolders::SpoolFolders(fs::path root) : root_(std::move(root)) {}

fs::path SpoolFolders::path(SpoolFolder folder) const {
  switch (folder) {
    case SpoolFolder::Incoming:
      return root_ / "incoming";
    case SpoolFolder::Printing:
      return root_ / "printing";
    case SpoolFolder::Done:
      return root_ / "done";
    case SpoolFolder::Failed:
      return root_ / "failed";
  }
  return root_;
}

bool SpoolFolders::is_plate(SpoolFolder where, const std::string& file) const {
  if (file.empty() || file.starts_with('.') || is_model_name(file)) return false;
  std::error_code code;
  return fs::is_directory(fs::symlink_status(path(where) / file, code));
}

JobFiles SpoolFolders::files_of(SpoolFolder where, const std::string& file) const {
  const fs::path model = path(where) / file;
  if (is_plate(where, file)) return {file, model, std::nullopt, true, Links::Refuse};
  const fs::path ticket = path(where) / (model_stem(file) + ".json");
  JobFiles files{job_name_of(file), model, std::nullopt, false, Links::Refuse};
  if (is_there(ticket)) files.ticket = ticket;
  return files;
}

JobFiles SpoolFolders::named(SpoolFolder where, const std::string& name, const JobFiles& like) const {
  const std::string_view extension = like.plate ? "" : model_extension(like.model.filename().string());
  JobFiles files{name, path(where) / (name + std::string(extension)), std::nullopt, like.plate, like.links};
  if (like.ticket) files.ticket = path(where) / (name + ".json");
  return files;
}

bool SpoolFolders::is_name_used(const std::string& name) const {
  // A reason file alone does not take a name: a power cut can leave it without its job, which is then filed
  // again.
  std::vector<std::string_view> suffixes{"", ".json", ".report.json", ".frames.bin", ".pictures"};
  std::ranges::copy(model_extensions(), std::back_inserter(suffixes));
  constexpr std::array kTaken{SpoolFolder::Printing, SpoolFolder::Done, SpoolFolder::Failed};
  return std::ranges::any_of(kTaken, [&](SpoolFolder where) {
    return std::ranges::any_of(suffixes, [&](std::string_view suffix) {
      return is_there(path(where) / (name + std::string(suffix)));
    });
  });
}

bool SpoolFolders::is_used_in_incoming(const std::string& name, const JobFiles& like) const {
  const JobFiles files = named(SpoolFolder::Incoming, name, like);
  return is_there(files.model) || (!like.plate && is_there(path(SpoolFolder::Incoming) / (name + ".json")));
}

std::string SpoolFolders::unused_name(const std::string& stem) const {
  return numbered(shortened_name(stem), [&](const std::string& name) { return is_name_used(name); });
}

JobFiles SpoolFolders::unused_in_incoming(const JobFiles& like) const {
  const auto is_used = [&](const std::string& name) { return is_used_in_incoming(name, like); };
  return named(SpoolFolder::Incoming, numbered(like.name, is_used), like);
}

JobFiles SpoolFolders::unused_anywhere(const JobFiles& like) const {
  const auto is_used = [&](const std::string& name) {
    return is_name_used(name) || is_used_in_incoming(name, like);
  };
  return named(SpoolFolder::Incoming, numbered(shortened_name(like.name), is_used), like);
}

bool SpoolFolders::shares_ticket(const JobFiles& job) const {
  if (!job.ticket || job.ticket->parent_path() != path(SpoolFolder::Incoming)) return false;
  const auto models = models_of_ticket(job.ticket->filename().string());
  return std::any_of(models.begin(), models.end(), [&](const fs::path& model) {
    std::error_code code;  // on a case-insensitive file system both paths are the same file
    return model != job.model && !fs::equivalent(model, job.model, code);
  });
}

std::vector<fs::path> SpoolFolders::models_of_ticket(const std::string& ticket) const {
  std::vector<fs::path> models;
  for (const std::string_view extension : model_extensions()) {
    for (const std::string& spelling : spellings_of(extension)) {
      const fs::path model = path(SpoolFolder::Incoming) / (fs::path(ticket).stem().string() + spelling);
      if (is_there(model)) models.push_back(model);
    }
  }
  return models;
}

std::string why_not_written(const std::error_code& code) {
  return code.message() + (code == std::errc::read_only_file_system ? kReadOnlyHint : "");
}

}  // namespace contourd
