/* For headed.comp. */
struct headed {
    double first, second;
};
static double headed_root(double x)
{
    return x > 0 ? sqrt(x) : 0;
}
