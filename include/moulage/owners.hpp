/** What all owners share: errors that are thrown, lists that are lent, handles that are freed. */
#ifndef MOULAGE_OWNERS_HPP
#define MOULAGE_OWNERS_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "../moulage.h"

namespace moulage {

/** A failed call; what() is the library's sentence. */
class Error : public std::runtime_error {
public:
    Error(MlgStatus status, const std::string &message) : std::runtime_error(message), status_(status) {}
    MlgStatus status() const noexcept { return status_; }
    /** Such as INVALID_ARGUMENT. */
    std::string status_name() const { return mlg_status_name(status_); }

private:
    MlgStatus status_;
};

/** Calls a C function with the arguments and an MlgError; throws if it fails. */
template <class Function, class... Arguments>
void call(Function function, Arguments... arguments) {
    MlgError error = {MLG_STATUS_OK, ""};
    const MlgStatus status = function(arguments..., &error);
    if (status != MLG_STATUS_OK) throw Error(status, error.message);
}

/** A list of somebody else, valid as long as its owner lives. A std::vector is one where a function takes it. */
template <class T> struct View {
    View() = default;
    View(const T *list, std::size_t count) : data(list), size(count) {}
    View(const std::vector<T> &list) : data(list.data()), size(list.size()) {}
    const T *data = nullptr;
    std::size_t size = 0;
    bool empty() const { return size == 0; }
    const T *begin() const { return data; }
    const T *end() const { return data + size; }
    const T &operator[](std::size_t i) const { return data[i]; }
};

/** A place or a direction. */
using Vector = std::array<double, 3>;

/** The number of rows of `width` numbers in a flat list; throws when the last one is not whole. */
template <class T> std::size_t rows(View<T> list, std::size_t width, const char *name) {
    if (list.size % width != 0)
        throw Error(MLG_STATUS_INVALID_ARGUMENT,
                    std::string(name) + ": " + std::to_string(list.size) + " numbers, but " +
                        std::to_string(width) + " of them belong together");
    return list.size / width;
}

/** Throws unless there are as many of the one as of the other. */
inline void check_same(std::size_t count, const char *name, std::size_t wanted, const char *of) {
    if (count != wanted)
        throw Error(MLG_STATUS_INVALID_ARGUMENT,
                    std::to_string(count) + " " + name + " for " + std::to_string(wanted) + " " + of);
}

/** Weights for a call; NULL, that is 1 throughout, when they are left out. */
inline const double *weights_for(View<double> weights, std::size_t count) {
    if (weights.empty()) return nullptr;
    check_same(weights.size, "weights", count, "points");
    return weights.data;
}

/** Options with their defaults. */
template <class Options> Options defaults(MlgStatus (*init)(Options *, std::size_t)) {
    Options options;
    init(&options, sizeof options);
    return options;
}

/** A struct that a C function fills. */
template <class Struct, class Function, class... Arguments>
Struct filled(Function function, Arguments... arguments) {
    Struct answer = {};
    answer.struct_size = sizeof answer;
    call(function, arguments..., &answer);
    return answer;
}

/** Makes a handle by a C function whose last arguments are the out handle and the error. */
template <class Handle, class Function, class... Arguments>
Handle *made(Function function, Arguments... arguments) {
    Handle *handle = nullptr;
    call(function, arguments..., &handle);
    return handle;
}

/** A text that a C function writes into a buffer; it is asked for the length first. `index`: of the part with that
    number, if one is given. */
template <class Function, class Handle, class... Index>
std::string text(Function function, const Handle *handle, Index... index) {
    std::size_t length = 0;
    call(function, handle, index..., nullptr, std::size_t(0), &length);
    std::string text(length + 1, '\0');
    call(function, handle, index..., &text[0], text.size(), &length);
    text.resize(length);
    return text;
}

/** A text that may be missing. */
inline std::string text_or_empty(const char *text) { return text == nullptr ? "" : text; }

/** A list of `width` numbers per element, given by a function that is told where to write the count. */
template <class T, class Getter> View<T> lent(std::size_t width, Getter getter) {
    std::size_t count = 0;
    const T *data = getter(&count);
    return {data, width * count};
}

/** Owns a handle; move-only. */
template <class Handle, void (*Free)(Handle *)> class Owner {
public:
    Owner() = default;
    explicit Owner(Handle *handle) : handle_(handle) {}
    Handle *get() const noexcept { return handle_.get(); }
    const Handle *as_const() const noexcept { return handle_.get(); }

protected:
    /** A handle of its own kind. */
    template <class Function, class... Arguments>
    static Handle *make(Function function, Arguments... arguments) {
        return made<Handle>(function, arguments...);
    }

private:
    struct Deleter {
        void operator()(Handle *handle) const noexcept { Free(handle); }
    };
    std::unique_ptr<Handle, Deleter> handle_;
};

/** Declares an accessor that lends a list, `width` numbers per element. Of a temporary it would dangle: that does not
 * compile. */
#define MOULAGE_LENDS(Type, name, getter, width)                                                   \
    View<Type> name() const & {                                                                    \
        return lent<Type>(width, [&](std::size_t *count) { return getter(as_const(), count); });   \
    }                                                                                              \
    View<Type> name() const && = delete;

/** The same for a part with a number, from 0. */
#define MOULAGE_LENDS_OF_EACH(Type, name, getter, width)                                           \
    View<Type> name(std::size_t number) const & {                                                  \
        return lent<Type>(width,                                                                   \
                          [&](std::size_t *count) { return getter(as_const(), number, count); });  \
    }                                                                                              \
    View<Type> name(std::size_t number) const && = delete;

}  // namespace moulage

#endif
