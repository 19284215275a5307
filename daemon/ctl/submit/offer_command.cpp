#include "daemon/ctl/submit/submit_commands.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/submit/foreign_folder.hpp"
#include "daemon/ctl/submit/spool_submission.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/formats/model_input.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/spool/why_ignored.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {
namespace {

struct OfferOptions {
  std::filesystem::path folder;
  std::optional<std::filesystem::path> spool;  // nullopt: ask contourd
  // Record of the files taken, which are not taken again. A file is identified by `label`, path, size and
  // time.
  std::optional<std::filesystem::path> once;
  std::string label;
};

namespace fs = std::filesystem;

constexpr std::size_t kMostModels = 20;
constexpr std::uint64_t kLargestModel = std::uint64_t{1} << 30U;
constexpr std::uint64_t kMostTogether = std::uint64_t{4} << 30U;
// Free space that must remain on the spool's disk.
constexpr std::uint64_t kLeftFree = std::uint64_t{256} << 20U;
constexpr std::size_t kMostReported = 20;

// A file of the folder that is not taken; what() is the reason, as a clause.
struct NotTaken : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct stat status_of(const FileDescriptor& file) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw std::system_error(errno, std::generic_category());
  return status;
}

std::string facts_of(const FileDescriptor& file) {
  const struct stat status = status_of(file);
  return fmt::format("{} {}.{}", status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
}

// Returns a name for the model in the spool that can be typed and cannot be confused with an option, whatever
// bytes the original name has.
std::string plain_name(const std::string& path) {
  const std::string file = fs::path(path).filename().string();
  std::string stem = printable(model_stem(file));
  std::ranges::replace(stem, '?', '_');
  if (stem.starts_with('-')) stem.front() = '_';
  return stem + std::string(model_extension(file));
}

void look_at(const FileDescriptor& model, std::uint64_t bytes, const std::string& path,
             const std::vector<std::string>& names) {
  if (bytes > kLargestModel)
    throw NotTaken(fmt::format("its size of {} bytes is above {}", bytes, kLargestModel));
  const int reading = ::dup(model.get());
  OpenFile file(reading < 0 ? nullptr : ::fdopen(reading, "rb"));
  if (!file) throw std::system_error(errno, std::generic_category());
  (void)open_models(ModelSource{std::move(file), bytes, path, {names}});
  if (::lseek(model.get(), 0, SEEK_SET) != 0) throw std::system_error(errno, std::generic_category());
}

// The record of files that were taken from USB sticks: a text file with one mark per line, the latest last.
// The oldest marks are dropped.
class TakenFiles {
 public:
  // Reads the file; a file that cannot be read counts as empty.
  explicit TakenFiles(const fs::path& path) : path_(fs::absolute(path)) {
    std::ifstream file(path_);
    for (std::string line; marks_.size() < kMost && std::getline(file, line);)
      marks_.push_back(line);
  }

  [[nodiscard]] bool contains(const std::string& mark) const {
    return std::ranges::find(marks_, mark) != marks_.end();
  }
  // Adds a mark and writes the file to disk. Throws std::system_error. REQUIRES: the mark has no line break.
  void add(const std::string& mark) {
    expects(mark.find('\n') == std::string::npos, "a mark is one line");
    marks_.push_back(mark);
    if (marks_.size() > kMost) marks_.pop_front();
    std::string text;
    for (const std::string& each : marks_)
      text += each + '\n';
    write_durably(path_, text);
  }

 private:
  static constexpr std::size_t kMost = 5'000;

  fs::path path_;
  std::deque<std::string> marks_;
};

class Offer {
 public:
  Offer(const ClientOptions& client, const OfferOptions& options)
      : client_(client),
        options_(options),
        folder_(options.folder),
        submission_(find_spool(client, options.spool)) {
    if (options.once) taken_.emplace(*options.once);
  }

  int run() {
    const FoundModels found = folder_.models();
    for (const std::string& path : found.paths) {
      if (jobs_ == kMostModels) {
        report_left(fmt::format(
            "only {} models are taken at a time; offer the folder again for the next ones", kMostModels));
        break;
      }
      consider(path);
    }
    for (const std::string& path : found.others)
      report_not_taken(path, sentence_for(*why_format_is_ignored(path)));
    if (!found.all)
      report_left(fmt::format("the folder has more than {} names; the others were ignored",
                              ForeignFolder::kMostNames));
    if (found.unread > 0) report_left(fmt::format("folders that cannot be read: {}", found.unread));
    if (unreported_ > 0) fmt::print(stderr, "contourctl: {} more are not taken\n", unreported_);
    if (jobs_ == 0 && !left_ && !client_.json)
      fmt::print("nothing to take{}\n",
                 before_ > 0 ? fmt::format("; {} were taken before", before_) : std::string());
    return left_ ? kBadData : kOk;
  }

 private:
  void consider(const std::string& path) {
    try {
      take(path);
    } catch (const NotTaken& why) {
      report_not_taken(path, why.what());
    } catch (const UnreadableFile& why) {
      report_not_taken(path, why.what());
    } catch (const ModelError& why) {
      report_not_taken(path, why.what());
    } catch (const std::system_error& why) {
      report_not_taken(path, why.code().message());
    }
  }

  void take(const std::string& path) {
    const FileDescriptor model = folder_.open(path);
    const FileDescriptor ticket = open_ticket(path);
    const std::string mark = mark_of(path, model, ticket);
    if (taken_ && taken_->contains(mark)) {
      ++before_;
      return;
    }
    const auto bytes = static_cast<std::uint64_t>(status_of(model).st_size);
    const std::string text = ticket.valid() ? text_of(ticket, JsonDocument::kLargestBytes) : "";
    look_at(model, bytes, path, models_named_by(text));
    require_room(bytes);
    const std::string job = submission_.put(plain_name(path), model, text, bytes);
    ++jobs_;
    bytes_ += bytes;
    tell_submitted(client_, path, job);
    if (taken_) note(mark);
  }

  [[nodiscard]] FileDescriptor open_ticket(const std::string& path) const {
    try {
      return folder_.open(model_stem(path) + ".json");
    } catch (const UnreadableFile& error) {
      // If the ticket's name would be too long, there is no ticket.
      if (error.code() == std::errc::no_such_file_or_directory ||
          error.code() == std::errc::filename_too_long)
        return {};
      throw NotTaken(fmt::format("its ticket cannot be read: {}", error.what()));
    }
  }

  [[nodiscard]] std::string mark_of(const std::string& path, const FileDescriptor& model,
                                    const FileDescriptor& ticket) const {
    const std::string facts = fmt::format("{}\n{}\n{}\n{}", options_.label, path, facts_of(model),
                                          ticket.valid() ? facts_of(ticket) : "");
    return base64({reinterpret_cast<const std::uint8_t*>(facts.data()), facts.size()});
  }

  void require_room(std::uint64_t bytes) const {
    if (bytes_ + bytes > kMostTogether)
      throw NotTaken(fmt::format("only {} bytes are taken at a time; offer the folder again", kMostTogether));
    struct statvfs disk {};
    if (::statvfs(submission_.incoming().c_str(), &disk) != 0)
      throw OutputError(fmt::format("cannot put anything into {}: {}", submission_.incoming().string(),
                                    std::generic_category().message(errno)));
    if (disk.f_bavail * disk.f_frsize < bytes + kLeftFree)
      throw NotTaken("the spool's disk has not enough room for it");
  }

  void note(const std::string& mark) {
    try {
      taken_->add(mark);
    } catch (const std::system_error& error) {
      throw OutputError(fmt::format("cannot record taken files in {}: {}", options_.once->string(),
                                    error.code().message()));
    }
  }

  void report_not_taken(const std::string& path, std::string_view why) {
    if (++reported_ <= kMostReported)
      report_left(fmt::format("{} is not taken: {}", in_quotes(path), why));
    else
      ++unreported_;
  }

  void report_left(const std::string& sentence) {
    left_ = true;
    fmt::print(stderr, "contourctl: {}\n", printable(sentence));
  }

  const ClientOptions& client_;
  const OfferOptions& options_;
  ForeignFolder folder_;
  SpoolSubmission submission_;
  std::optional<TakenFiles> taken_;
  std::size_t jobs_ = 0, before_ = 0, reported_ = 0, unreported_ = 0;
  std::uint64_t bytes_ = 0;
  bool left_ = false;
};

}  // namespace

void add_offer(Command& program) {
  Command& command = program.add("offer", "Add the models of an untrusted folder (a USB stick) to the queue");
  auto& options = command.arguments<OfferOptions>();
  command.option("FOLDER", options.folder, "Folder with models; links in it are not followed").required();
  command.option("--spool", options.spool, kSpoolHelp);
  const Option& once =
      command.option("--once", options.once, "Queue each model only once; record queued models in this file");
  command.option("--label", options.label, "Name of this folder in the record of --once").needs(once);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &options] { return Offer(client, options).run(); };
}

}  // namespace contourd::ctl
