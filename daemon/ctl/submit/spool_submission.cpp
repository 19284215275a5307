#include "daemon/ctl/submit/spool_submission.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <string_view>
#include <system_error>
#include <vector>

#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

// Calls `take` with each piece of the file. Throws UnreadableFile, and the exceptions of `take`.
void read_all(const FileDescriptor& file, std::uint64_t most,
              const std::function<void(std::string_view)>& take) {
  std::vector<char> buffer(std::size_t{1} << 20U);
  for (std::uint64_t left = most;;) {
    const ssize_t bytes = ::read(file.get(), buffer.data(), buffer.size());
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) throw UnreadableFile({errno, std::generic_category()}, std::strerror(errno));
    if (bytes == 0) return;
    const auto size = static_cast<std::size_t>(bytes);
    if (size > left)
      throw UnreadableFile(std::make_error_code(std::errc::file_too_large),
                           fmt::format("it has more than {} bytes", most));
    left -= size;
    take({buffer.data(), size});
  }
}

}  // namespace

std::string text_of(const FileDescriptor& file, std::uint64_t most) {
  std::string text;
  read_all(file, most, [&text](std::string_view bytes) { text += bytes; });
  return text;
}

SpoolSubmission::SpoolSubmission(const fs::path& spool)
    : folders_(spool), incoming_(folders_.path(SpoolFolder::Incoming)) {}

std::string SpoolSubmission::put(const std::string& name, const FileDescriptor& model,
                                 const std::string& ticket, std::uint64_t most) const {
  try {
    return put_unused(name, model, ticket, most);
  } catch (const UnreadableFile&) {
    throw;
  } catch (const std::system_error& error) {
    throw OutputError(
        fmt::format("cannot put {} into {}: {}", name, incoming_.string(), why_not_written(error.code())));
  }
}

std::string SpoolSubmission::put_unused(const std::string& name, const FileDescriptor& model,
                                        const std::string& ticket, std::uint64_t most) const {
  NewFile file(incoming_);
  file.let_group_read();
  read_all(model, most, [&file](std::string_view bytes) { file.write(bytes); });
  while (true) {
    const JobFiles files = folders_.unused_anywhere({model_stem(name), name, name});
    if (!ticket.empty() && !put_ticket(files, ticket)) continue;
    if (file.appear(files.model.filename().string())) {
      sync_folder(incoming_);
      return files.name;
    }
    if (!ticket.empty()) fs::remove(*files.ticket);
  }
}

bool SpoolSubmission::put_ticket(const JobFiles& files, const std::string& ticket) const {
  NewFile file(incoming_);
  file.let_group_read();
  file.write(ticket);
  return file.appear(files.ticket->filename().string());
}

}  // namespace contourd::ctl
