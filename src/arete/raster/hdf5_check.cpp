#include "arete/raster/hdf5_check.h"

#include <fmt/format.h>
#include <hdf5.h>

#include "arete/core/error.h"

namespace arete::raster {
namespace {

// Closes an HDF5 identifier of any kind.
class Identifier {
 public:
  explicit Identifier(hid_t id) : id_(id) {}
  ~Identifier() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  Identifier(const Identifier&) = delete;
  Identifier& operator=(const Identifier&) = delete;
  hid_t get() const { return id_; }
  bool good() const { return id_ >= 0; }

 private:
  hid_t id_;
};

// HDF5 prints its error stack unless told otherwise.
class Silence {
 public:
  Silence() {
    H5Eget_auto2(H5E_DEFAULT, &report_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Silence() { H5Eset_auto2(H5E_DEFAULT, report_, data_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  H5E_auto2_t report_ = nullptr;
  void* data_ = nullptr;
};

constexpr herr_t kGoOn = 0, kOutside = 1;

herr_t look_at_link(hid_t, const char*, const H5L_info_t* info, void*) {
  return info->type == H5L_TYPE_HARD || info->type == H5L_TYPE_SOFT ? kGoOn : kOutside;
}

herr_t look_at_object(hid_t root, const char* name, const H5O_info_t* info, void*) {
  if (info->type != H5O_TYPE_DATASET) return kGoOn;
  const Identifier dataset(H5Dopen2(root, name, H5P_DEFAULT));
  if (!dataset.good()) return -1;
  const Identifier creation(H5Dget_create_plist(dataset.get()));
  if (!creation.good()) return -1;
  const bool outside =
      H5Pget_external_count(creation.get()) != 0 || H5Pget_layout(creation.get()) == H5D_VIRTUAL;
  return outside ? kOutside : kGoOn;
}

// kGoOn when all links and datasets stay in the file.
herr_t look_everywhere(hid_t file) {
  const herr_t links = H5Lvisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, look_at_link, nullptr);
  if (links != kGoOn) return links;
  return H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, look_at_object, nullptr, H5O_INFO_BASIC);
}

}  // namespace

void check_hdf5(const std::filesystem::path& path) {
  const Silence silence;
  if (H5Fis_hdf5(path.c_str()) <= 0) return;
  const std::string name = path.filename().string();
  const Identifier file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  const herr_t found = file.good() ? look_everywhere(file.get()) : -1;
  if (found < 0) {
    throw Error(ErrorCode::InvalidInput, fmt::format("{}: damaged HDF5: fetch it again", name));
  }
  if (H5Lexists(file.get(), "BAG_root", H5P_DEFAULT) > 0) {
    throw Error(ErrorCode::Unsupported,
                fmt::format("{}: a BAG, whose place is not read: convert it to GeoTIFF "
                            "(gdal_translate)",
                            name));
  }
  if (found != kGoOn) {
    throw Error(
        ErrorCode::Unsupported,
        fmt::format("{}: keeps its samples in other files: repack it into one (h5repack)", name));
  }
}

}  // namespace arete::raster
