#include "daemon/prepare/model_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <new>
#include <system_error>
#include <utility>

#include "daemon/prepare/plate_arrangement.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

template <typename Work>
auto ModelFile::or_refuse(Work work) const {
  try {
    return work();
  } catch (const UnreadableFile& error) {
    throw JobRefused(fmt::format("cannot read {}: {}", printable(path_.string()), error.what()));
  } catch (const ModelError& error) {
    throw JobRefused(fmt::format("{}not a usable model: {}", prefix_, error.what()));
  } catch (const std::bad_alloc&) {
    throw JobRefused(prefix_ + "the model does not fit into this machine's memory");
  }
}

ModelFile::ModelFile(std::filesystem::path path, const std::string& name, Links links)
    : path_(std::move(path)), prefix_(name.empty() ? "" : name + ": ") {
  or_refuse([&] {
    open(links);
    outline_ = outline_of_model(file_.get(), bytes_, path_);
    return 0;
  });
}

Model ModelFile::read() {
  return or_refuse([this] {
    Model model = read_model_file(file_.get(), bytes_, path_);
    file_.reset();
    if (model.facets.empty()) throw JobRefused(prefix_ + "the file holds no facets");
    return model;
  });
}

void ModelFile::open(Links links) {
  const FileDescriptor opened = open_regular_file(path_, links);
  struct stat status {};
  file_.reset(::fdopen(::fcntl(opened.get(), F_DUPFD_CLOEXEC, 0), "rb"));
  if (!file_ || ::fstat(opened.get(), &status) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot read " + path_.string());
  bytes_ = static_cast<std::uint64_t>(status.st_size);
}

}  // namespace contourd
