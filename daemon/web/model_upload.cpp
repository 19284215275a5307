#include "daemon/web/model_upload.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "daemon/formats/model_names.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::web {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kTooLarge = 413, kFailed = 500, kNoRoom = 507;
constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20U;

UploadRefusal refusal_of(const std::string& name, const std::error_code& code) {
  const bool full = code == std::errc::no_space_on_device || code.value() == EDQUOT;
  return {full ? kNoRoom : kFailed,
          fmt::format("{} cannot be stored on the printer: {}", printable(name), why_not_written(code))};
}

}  // namespace

struct ModelUpload::File {
  SpoolFolders folders;
  std::string name;
  UploadLimits limits;
  std::optional<NewFile> file{};
  std::uint64_t bytes = 0;

  [[nodiscard]] fs::path incoming() const { return folders.path(SpoolFolder::Incoming); }

  // Returns a refusal if the disk has no room for more bytes.
  [[nodiscard]] std::optional<UploadRefusal> why_no_room(std::uint64_t more) const {
    struct statvfs disk {};
    if (::statvfs(incoming().c_str(), &disk) != 0) return std::nullopt;  // opening the file tells why
    if (static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize >= limits.free_bytes + more)
      return std::nullopt;
    const std::string left = limits.free_bytes < kMebibyte
                                 ? "is full"
                                 : fmt::format("has less than {} MiB left", limits.free_bytes / kMebibyte);
    return UploadRefusal{
        kNoRoom, fmt::format("{} cannot be stored: the printer's disk {}; delete finished jobs in {}",
                             printable(name), left, printable(folders.path(SpoolFolder::Done).string()))};
  }

  [[nodiscard]] std::optional<UploadRefusal> write(const std::string& more) {
    bytes += more.size();
    if (bytes > limits.most_bytes)
      return UploadRefusal{kTooLarge,
                           fmt::format("{} is too large: the printer takes models of at most {} MiB",
                                       printable(name), limits.most_bytes / kMebibyte)};
    if (std::optional<UploadRefusal> refusal = why_no_room(more.size())) return refusal;
    try {
      open();
      file->write(more);
    } catch (const std::system_error& error) {
      return refusal_of(name, error.code());
    }
    return std::nullopt;
  }

  void open() {
    if (file) return;
    file.emplace(incoming());
    file->let_group_read();
  }

  // Returns the job's name.
  [[nodiscard]] std::string appear(const std::string& ticket) {
    open();
    while (true) {
      const JobFiles files = folders.unused_anywhere({model_stem(name), name, name});
      if (!ticket.empty() && !put_ticket(*files.ticket, ticket)) continue;
      if (!appear_as(files, !ticket.empty())) continue;
      sync_folder(incoming());
      return files.name;
    }
  }

  // Returns false if another ticket has the name.
  [[nodiscard]] bool put_ticket(const fs::path& path, const std::string& text) const {
    NewFile ticket(incoming());
    ticket.let_group_read();
    ticket.write(text);
    return ticket.appear(path.filename().string());
  }

  // Gives the model its name. If it cannot have it, the ticket goes again.
  [[nodiscard]] bool appear_as(const JobFiles& files, bool has_ticket) {
    const auto take_back = [&] {
      std::error_code gone;
      if (has_ticket) fs::remove(*files.ticket, gone);
    };
    try {
      if (file->appear(files.model.filename().string())) return true;
    } catch (const std::system_error&) {
      take_back();
      throw;
    }
    take_back();
    return false;
  }
};

ModelUpload::ModelUpload(Worker& disk, fs::path spool, std::string name, UploadLimits limits)
    : disk_(disk), file_(new File{SpoolFolders(std::move(spool)), std::move(name), limits}) {}

void ModelUpload::write(std::string bytes, Written written) {
  disk_.run([file = file_, bytes = std::move(bytes)] { return file->write(bytes); }, std::move(written));
}

void ModelUpload::finish(std::string ticket, Finished finished) {
  using Result = std::pair<std::optional<UploadRefusal>, std::string>;
  disk_.run(
      [file = file_, ticket = std::move(ticket)]() -> Result {
        try {
          return {std::nullopt, file->appear(ticket)};
        } catch (const std::system_error& error) {
          return {refusal_of(file->name, error.code()), ""};
        }
      },
      [finished = std::move(finished)](const Result& result) { finished(result.first, result.second); });
}

}  // namespace contourd::web
