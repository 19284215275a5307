#include "daemon/ctl/commands.hpp"
#include "daemon/job_memory.hpp"

namespace contourd::ctl {
namespace {

void require_memory(const std::filesystem::path& path) {
  const FileToRead file{outline_of_stl(path)};
  const MemoryRoom room = memory_room(std::nullopt);
  const std::uint64_t needed = memory_to_prepare({&file, 1}, DisplayGeometry{});
  if (needed > room.bytes) throw JobTooLarge({&file, 1}, "", needed, room);
}

}  // namespace

StlModel read_model(const std::filesystem::path& path) {
  try {
    require_memory(path);
    return read_stl_file(path);
  } catch (const StlError& error) {
    throw StlError(path.string() + ": " + error.what());
  } catch (const JobTooLarge& error) {
    throw StlError(path.string() + ": " + error.what());
  }
}

}  // namespace contourd::ctl
