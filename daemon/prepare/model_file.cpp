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
    throw JobRefused(fmt::format("cannot read {}: {}", printable(place_.path.string()), error.what()));
  } catch (const ModelError& error) {
    throw JobRefused(fmt::format("{}not a usable model: {}", prefix_, error.what()));
  } catch (const std::bad_alloc&) {
    throw JobRefused(prefix_ + "the model does not fit into this machine's memory");
  }
}

ModelFile::ModelFile(ModelPlace place, const std::string& name)
    : place_(std::move(place)), prefix_(name.empty() ? "" : name + ": ") {
  input_ = or_refuse([this] { return open(); });
}

Model ModelFile::read(std::uint64_t most_facets) {
  return or_refuse([&] {
    Model model = input_->read(most_facets);
    if (model.facets.empty()) throw JobRefused(prefix_ + "the file holds no facets");
    return model;
  });
}

std::unique_ptr<ModelInput> ModelFile::open() const {
  const FileDescriptor opened = open_regular_file(place_.path, place_.links);
  struct stat status {};
  ModelSource source{OpenFile(::fdopen(::fcntl(opened.get(), F_DUPFD_CLOEXEC, 0), "rb")), 0, place_.path,
                     place_.entry};
  if (!source.file || ::fstat(opened.get(), &status) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot read " + place_.path.string());
  source.bytes = static_cast<std::uint64_t>(status.st_size);
  return open_model(std::move(source));
}

}  // namespace contourd
