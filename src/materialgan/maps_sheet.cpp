#include "materialgan/maps_sheet.h"

#include "materialgan/network/contact_sheet.h"

namespace lacquer::materialgan {

Image MapsSheet(const std::vector<std::vector<capture::Maps>>& rows) {
    std::vector<Tensor> batches;
    for (const std::vector<capture::Maps>& row : rows) {
        std::vector<Tensor> maps;
        for (const capture::Maps& one : row) maps.push_back(ToTensor(one));
        batches.push_back(torch::stack(maps));
    }
    return ContactSheet(batches);
}

}  // namespace lacquer::materialgan
