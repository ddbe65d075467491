/** C++17 over moulage.h: owners that free, errors that are thrown. Nothing is declared twice: options and summaries are
 * the C structs.
 *
 *     moulage::TriMesh surface("liver.obj");
 *     moulage::Markers markers("clicks.csv");
 *     moulage::Tetrahedralization tets(surface);
 *     moulage::Reshaping problem(tets);
 *     problem.set_markers(markers.points());
 *     moulage::ReshapingResult result = problem.run();
 *     surface.save("person.obj", result.points());
 */
#ifndef MOULAGE_HPP
#define MOULAGE_HPP

#include "moulage/registration.hpp"
#include "moulage/separation.hpp"

namespace moulage {

/** Throws if the library that was loaded does not fit this header. */
inline void check_version() {
    if (mlg_abi_version() != MLG_ABI_VERSION)
        throw Error(MLG_STATUS_UNSUPPORTED, "the moulage library and its header do not fit");
}

/** The library's version, such as 0.1.0. */
inline std::string version() { return mlg_version_string(); }

}  // namespace moulage

#endif
