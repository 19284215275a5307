// Files that a client reads in pieces, because a message of the control socket is short. Each reply has the
// file's size (`bytes`), the piece's position (`from`), the piece in Base64 (`data`), and a number by which
// the client asks for the next piece of the same file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "daemon/control/control_method.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

// Maximum number of a file's bytes in one reply.
inline constexpr std::size_t kPieceBytes = 49'152;

// Returns a parameter that a client takes from the previous reply.
[[nodiscard]] ControlParameter piece_parameter(const char* name, const char* meaning);

// Adds the piece at `from` of a file that is in memory. REQUIRES: from <= file.size().
void add_piece(ControlMethod::Json& reply, std::span<const std::uint8_t> file, std::size_t from);

// The piece of a file that a client wants. `what` names the file in refusals: "the report".
struct WantedPiece {
  std::string what;
  std::uint64_t version = 0, from = 0;  // version 0: whatever the file is now
};
// Returns the piece that these parameters ask for. Throws InvalidParameters.
[[nodiscard]] WantedPiece wanted_piece(std::string what, const ControlMethod::Json& given);

// Adds the file's `version` and a piece of it. Follows no symbolic link. Blocks. Throws ControlRefusal, also
// if the file is no longer of the wanted version.
void add_piece(ControlMethod::Json& reply, const std::filesystem::path& path, const WantedPiece& wanted);

// Calls `read`, which returns a reply or throws ControlRefusal, on the spool's thread, then `later` with the
// result from the loop. The spool must outlive that call.
template <typename Read>
void read_later(Spool& spool, ControlMethod::Later later, Read read) {
  using Result = std::variant<ControlMethod::Json, ControlRefusal>;
  spool.run(
      [read = std::move(read)]() -> Result {
        try {
          return read();
        } catch (const ControlRefusal& refusal) {
          return refusal;
        }
      },
      std::move(later));
}

// True if the text is the name of a job's files in their folder, and no path to another.
[[nodiscard]] bool is_own_name(std::string_view name);

}  // namespace contourd
