#include "daemon/system/standard_output.hpp"

#include <cerrno>
#include <cstdio>
#include <system_error>

namespace contourd {

int print_whole(const std::function<int()>& run) {
  std::error_code why(EIO, std::generic_category());  // the errno of earlier failures is lost
  try {
    const int code = run();
    const bool flushed = std::fflush(stdout) == 0;
    if (!flushed) why.assign(errno, std::generic_category());
    if (flushed && std::ferror(stdout) == 0) return code;
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) == 0) throw;
    why = error.code();
  }
  throw OutputError("cannot write the result: " + why.message());
}

}  // namespace contourd
