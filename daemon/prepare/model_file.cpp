#include "daemon/prepare/model_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <new>
#include <system_error>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/formats/sl1_outlines.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

namespace {

std::string prefix_for(const std::string& name) {
  return name.empty() ? "" : name + ": ";
}

// Calls `work` and turns its exceptions into JobRefused.
template <typename Work>
auto or_refuse(const std::filesystem::path& file, const std::string& prefix, Work work) {
  try {
    return work();
  } catch (const UnreadableFile& error) {
    throw JobRefused(fmt::format("cannot read {}: {}", printable(file.string()), error.what()));
  } catch (const ModelError& error) {
    throw JobRefused(fmt::format("{}not a usable model: {}", prefix, error.what()));
  } catch (const std::bad_alloc&) {
    throw JobRefused(prefix + "the model does not fit into this machine's memory");
  }
}

OpenedModels open(const ModelPlace& place) {
  const FileDescriptor opened = open_regular_file(place.path, place.links);
  struct stat status {};
  ModelSource source{OpenFile(::fdopen(::fcntl(opened.get(), F_DUPFD_CLOEXEC, 0), "rb")), 0, place.path,
                     place.choice};
  if (!source.file || ::fstat(opened.get(), &status) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot read " + place.path.string());
  source.bytes = static_cast<std::uint64_t>(status.st_size);
  return open_models(std::move(source));
}

}  // namespace

ModelFile::ModelFile(std::filesystem::path file, OpenedModel opened, const std::string& name)
    : file_(std::move(file)), opened_(std::move(opened)), prefix_(prefix_for(name)) {}

Model ModelFile::read(std::uint64_t most_facets) {
  return or_refuse(file_, prefix_, [&] {
    Model model = opened_.input->read(most_facets);
    if (model.facets.empty()) throw JobRefused(prefix_ + "the file holds no facets");
    return model;
  });
}

FinishedLayers ModelFile::read_layers(const DisplayGeometry& display, std::uint64_t most_bytes,
                                      const std::stop_token& stop) const {
  expects(sliced() != nullptr, "the file holds finished layers");
  try {
    if (sliced()->has_outlines()) return {nullptr, read_outlines(*sliced(), display, most_bytes, stop)};
    return {sliced()->read(display, most_bytes, stop), nullptr};
  } catch (const ModelError& error) {
    throw JobRefused(fmt::format("the file's layers cannot be printed: {}", error.what()));
  }
}

ModelFiles open_model_files(const ModelPlace& place, const std::string& name) {
  OpenedModels opened = or_refuse(place.path, prefix_for(name), [&] { return open(place); });
  ModelFiles made{{}, std::move(opened.notes)};
  const bool several = opened.models.size() > 1;
  for (OpenedModel& model : opened.models) {
    const std::string entry = several ? printable(model.entry) : "";
    const std::string between = name.empty() || entry.empty() ? "" : "/";
    made.files.emplace_back(place.path, std::move(model), name + between + entry);
  }
  return made;
}

}  // namespace contourd
