#include "daemon/spool_folders.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <utility>

#include "core/formats/model_reader.hpp"
#include "daemon/config/printer_places.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

// File names have at most 255 bytes; a job's name leaves room for a number and for what is written beside it.
constexpr std::size_t kLongestName = 200;

bool is_there(const fs::path& path) {
  std::error_code code;  // a name that is too long is nobody's
  return fs::exists(fs::symlink_status(path, code));
}

// NAME, NAME-2, NAME-3 ...: the first that is free.
template <typename IsUsed>
std::string numbered(const std::string& name, const IsUsed& is_used) {
  std::string candidate = name;
  for (int number = 2; is_used(candidate); ++number)
    candidate = fmt::format("{}-{}", name, number);
  return candidate;
}

// Not cut in the middle of a UTF-8 sequence, which has at most three continuation bytes.
std::string shortened_name(const std::string& stem) {
  std::string name = stem.substr(0, kLongestName);
  const auto continues = [&](std::size_t at) {
    return at < stem.size() && (static_cast<unsigned char>(stem[at]) & 0xC0U) == 0x80;
  };
  for (int i = 0; i < 3 && continues(name.size()); ++i)
    name.pop_back();
  return name;
}

}  // namespace

std::string job_name_of(const std::string& file) {
  return is_model_name(file) ? fs::path(file).stem().string() : file;
}

bool is_model_name(const std::string& file) {
  return has_model_extension(file) && !file.starts_with('.');
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
  fs::path ticket = model;
  ticket.replace_extension(".json");
  JobFiles files{job_name_of(file), model, std::nullopt, false, Links::Refuse};
  if (is_there(ticket)) files.ticket = ticket;
  return files;
}

JobFiles SpoolFolders::named(SpoolFolder where, const std::string& name, const JobFiles& like) const {
  JobFiles files{name, path(where) / (like.plate ? name : name + ".stl"), std::nullopt, like.plate,
                 like.links};
  if (like.ticket) files.ticket = path(where) / (name + ".json");
  return files;
}

std::string SpoolFolders::unused_name(const std::string& stem) const {
  const auto is_used_in = [this](SpoolFolder where, const std::string& name) {
    // A reason alone is no job: a power cut leaves it without its file, which gets it again.
    for (const char* suffix : {"", ".stl", ".json", ".report.json"}) {
      if (is_there(path(where) / (name + suffix))) return true;
    }
    return false;
  };
  return numbered(shortened_name(stem), [&](const std::string& name) {
    return is_used_in(SpoolFolder::Printing, name) || is_used_in(SpoolFolder::Done, name) ||
           is_used_in(SpoolFolder::Failed, name);
  });
}

JobFiles SpoolFolders::unused_in_incoming(const JobFiles& like) const {
  const std::string name = numbered(like.name, [&](const std::string& candidate) {
    const JobFiles files = named(SpoolFolder::Incoming, candidate, like);
    return is_there(files.model) ||
           (!like.plate && is_there(path(SpoolFolder::Incoming) / (candidate + ".json")));
  });
  return named(SpoolFolder::Incoming, name, like);
}

bool SpoolFolders::shares_ticket(const JobFiles& job) const {
  if (!job.ticket || job.ticket->parent_path() != path(SpoolFolder::Incoming)) return false;
  const auto models = models_of_ticket(job.ticket->filename().string());
  return std::any_of(models.begin(), models.end(), [&](const fs::path& model) {
    std::error_code code;  // where upper and lower case are the same, so are the files
    return model != job.model && !fs::equivalent(model, job.model, code);
  });
}

std::vector<fs::path> SpoolFolders::models_of_ticket(const std::string& ticket) const {
  constexpr unsigned kSpellings = 1U << 3U;  // each of three letters is upper or lower case
  std::vector<fs::path> models;
  for (unsigned upper = 0; upper < kSpellings; ++upper) {
    std::string extension = ".stl";
    for (unsigned i = 0; i < 3; ++i) {
      if ((upper >> i & 1U) != 0) extension[i + 1] = static_cast<char>(extension[i + 1] - 'a' + 'A');
    }
    fs::path model = path(SpoolFolder::Incoming) / ticket;
    model.replace_extension(extension);
    if (is_there(model)) models.push_back(model);
  }
  return models;
}

std::string why_not_written(const std::error_code& code) {
  return code.message() + (code == std::errc::read_only_file_system ? kReadOnlyHint : "");
}

}  // namespace contourd
