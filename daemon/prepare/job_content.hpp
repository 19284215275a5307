// The models that a job's ticket names and the files that they are made of: opened together, checked against
// the memory that there is, then read. A plate may name a file many times: it is read once, and what is alike
// is made once. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/prepare/job_memory.hpp"
#include "daemon/prepare/model_file.hpp"
#include "daemon/system/memory_room.hpp"

namespace contourd {

struct NamedModel {
  ModelTicket ticket;
  std::string name;  // as messages have it
  std::size_t file;  // of the job's files
  std::size_t
      made_as;  // the first model that is turned and scaled alike, of the same file: itself, or one before
};

class JobContent {
 public:
  // Opens the files. `folder_or_model`: the plate's folder, or the one model's file. Throws JobRefused.
  JobContent(const std::filesystem::path& folder_or_model, bool plate, Links links, const JobTicket& ticket);

  [[nodiscard]] const std::vector<NamedModel>& models() const { return models_; }
  [[nodiscard]] bool is_first_of_file(std::size_t model) const;

  // Reads them all, if there is room for what the job is to take. Throws JobRefused, of which JobTooLarge
  // says that there is none; then nothing was read.
  void read(const DisplayGeometry& display, const MemoryRoom& room);
  // What shows only behind that. Throw JobTooLarge if it is too much for the room that there was before
  // anything was read: to mend these facets of a model; to find and lead what holds all of them; to have
  // masks of them, whose contours may be moved.
  void require_room_to_repair(std::span<const Facet> facets);
  void require_room_for_supports(std::span<const PlateModel> models, const DisplayGeometry& display) const;
  void require_room_for_masks(std::span<const PlateModel> models, bool moved) const;

  [[nodiscard]] std::string_view format(std::size_t file) const { return files_[file].outline().format; }
  // Of a file, once it is read.
  [[nodiscard]] const std::vector<std::string>& warnings(std::size_t file) const {
    return read_[file].warnings;
  }
  // What the model is made of. To be called in the models' order, for those that are made.
  [[nodiscard]] std::vector<Facet> take_facets(std::size_t model);

 private:
  void add(const ModelTicket& ticket, const std::filesystem::path& folder_or_model, bool plate, Links links);

  std::vector<NamedModel> models_;
  std::vector<ModelFile> files_;
  std::vector<FileToRead> to_read_;  // of each
  std::vector<Model> read_;          // by file
  std::uint64_t needed_ = 0;
  std::uint64_t repairing_ = 0;  // that may be needed beside it
  MemoryRoom room_;
};

}  // namespace contourd
