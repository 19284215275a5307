#include "daemon/control/report_control.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {

using Json = ReportControl::Json;

namespace {

struct ReportPiece {
  std::string job;
  std::uint64_t version = 0, from = 0;
};

// True if the text is the name of a file in its own folder.
bool is_own_name(std::string_view name) {
  constexpr std::size_t kLongest = 200;
  return name.size() <= kLongest && !name.starts_with('.') &&
         name.find_first_of(std::string_view("/\0", 2)) == std::string_view::npos;
}

// Returns a number that another content of the file would not have, small enough for every JSON parser.
std::uint64_t version_of(const struct stat& file) {
  const auto nanoseconds = static_cast<std::uint64_t>(file.st_mtim.tv_sec) * 1'000'000'000U +
                           static_cast<std::uint64_t>(file.st_mtim.tv_nsec);
  return 1 + (nanoseconds ^ (static_cast<std::uint64_t>(file.st_ino) << 20U)) % (std::uint64_t{1} << 52U);
}

std::vector<std::uint8_t> read_at(int file, std::uint64_t from, std::size_t most) {
  std::vector<std::uint8_t> bytes(most);
  const ssize_t got = ::pread(file, bytes.data(), bytes.size(), static_cast<off_t>(from));
  if (got < 0) throw ControlRefusal(fmt::format("the report cannot be read: {}", std::strerror(errno)));
  bytes.resize(static_cast<std::size_t>(got));
  return bytes;
}

// Blocks. Throws ControlRefusal and UnreadableFile.
Json read_piece(const Spool& spool, const ReportPiece& wanted) {
  std::filesystem::path path;
  const char* folder = "done";
  if (is_own_name(wanted.job)) {
    path = spool.reports_of(Spool::Folder::Done, wanted.job).html;
    if (path.empty()) {
      folder = "failed";
      path = spool.reports_of(Spool::Folder::Failed, wanted.job).html;
    }
  }
  if (path.empty()) throw ControlRefusal(fmt::format("there is no report of {}", in_quotes(wanted.job)));
  const FileDescriptor file = open_regular_file(path, Links::Refuse);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0)
    throw ControlRefusal(fmt::format("the report cannot be read: {}", std::strerror(errno)));
  const std::uint64_t version = version_of(status), bytes = static_cast<std::uint64_t>(status.st_size);
  if (wanted.version != 0 && wanted.version != version)
    throw ControlRefusal(
        fmt::format("the report of {} has changed meanwhile; try again", in_quotes(wanted.job)));
  if (wanted.from > bytes)
    throw ControlRefusal(fmt::format("from must be at most {}, the size of the report in bytes", bytes));
  const auto piece = read_at(file.get(), wanted.from, ReportControl::kPieceBytes);
  return {{"job", wanted.job}, {"folder", folder},    {"version", version},
          {"bytes", bytes},    {"from", wanted.from}, {"data", base64(piece)}};
}

}  // namespace

ControlMethods ReportControl::methods() {
  const auto number = [](const char* name, const char* meaning) {
    return ControlParameter::whole_number(name, 0, ControlParameter::kMost, meaning)
        .described_as("a whole number, taken from the previous reply");
  };
  using Result = std::variant<Json, ControlRefusal>;
  return {{"report",
           {.description = "Returns the report page of a print that has ended, in pieces of an HTML file.",
            .parameters = {ControlParameter::text("job", "the job's name, as in the history").needed(),
                           number("version", "the version of the report, for the next piece"),
                           number("from", "position of the piece: the number of bytes received")},
            .call_later = [this](const Json& given, const ControlCaller&, ControlMethod::Later later) {
              const ReportPiece wanted{given["job"].get<std::string>(),
                                       given.value("version", std::uint64_t{0}),
                                       given.value("from", std::uint64_t{0})};
              if (wanted.from != 0 && wanted.version == 0) throw InvalidParameters("from needs version");
              spool_.run(
                  [&spool = spool_, wanted]() -> Result {
                    try {
                      return read_piece(spool, wanted);
                    } catch (const ControlRefusal& refusal) {
                      return refusal;
                    } catch (const UnreadableFile& error) {
                      return ControlRefusal(fmt::format("the report cannot be read: {}", error.what()));
                    }
                  },
                  std::move(later));
            }}}};
}

}  // namespace contourd
